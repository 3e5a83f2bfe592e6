"""How fast Mitsuba 3 converges on the reference scenes, beside `cargo bench -p brewster-tests --bench speed`, whose fields it prints.

    pip install mitsuba
    python tools/mitsuba/speed.py [SCENE...] [--variant scalar_rgb] [--sampler independent] [--threads 1] [--spp 64]

Builds tests/references/specs/NAME.json, the descriptions that the references were rendered from, with the same integrators; those that move
are left to moving.py. The LLVM variants need LLVM's shared library, which DRJIT_LIBLLVM_PATH may name.
"""
import argparse
import json
import pathlib
import statistics
import time

import drjit as dr
import mitsuba as mi
import numpy as np

REFERENCES = pathlib.Path(__file__).parents[2] / "tests" / "references"
PICTURES = 3


def color(value):
    return {"type": "rgb", "value": value}


def reflectance(albedo):
    if not isinstance(albedo, dict):
        return color(albedo)
    squares = albedo["scale"] / 2
    return {"type": "checkerboard", "color0": color(albedo["checker"][0]), "color1": color(albedo["checker"][1]),
            "to_uv": mi.ScalarTransform4f().scale([squares, squares, 1])}


def bsdf(material):
    rough = {"alpha": material["alpha"], "distribution": "ggx"} if "alpha" in material else {}
    prefix = "rough" if rough else ""
    match material["kind"]:
        case "diffuse":
            return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": reflectance(material["albedo"])}}
        case "conductor":
            metal = {"type": prefix + "conductor", "eta": color(material["eta"]), "k": color(material["k"]), **rough}
            return {"type": "twosided", "inner": metal}
        case "dielectric":
            return {"type": prefix + "dielectric", "int_ior": material["ior"], "ext_ior": material.get("ext_ior", 1.0), **rough}


def transform(shape):
    if "matrix" in shape:
        return mi.ScalarTransform4f(shape["matrix"])
    to_world = mi.ScalarTransform4f()
    if "translate" in shape:
        to_world = to_world.translate(shape["translate"])
    for axis, angle in shape.get("rotate", []):
        to_world = to_world.rotate(axis, angle)
    return to_world.scale(shape["scale"]) if "scale" in shape else to_world


def shape_of(shape, materials):
    made = {"to_world": transform(shape)}
    match shape["kind"]:
        case "sphere":
            made |= {"type": "sphere", "center": shape["center"], "radius": shape["radius"]}
        case "quad":
            made["type"] = "rectangle"
        case "cube" | "disk":
            made["type"] = shape["kind"]
        case "mesh":
            made |= {"type": "ply", "filename": str(REFERENCES / shape["file"])}
    if "emission" in shape:
        made["emitter"] = {"type": "area", "radiance": color(shape["emission"])}
        made["bsdf"] = {"type": "diffuse", "reflectance": color([0, 0, 0])}
        return made
    material = materials[shape["material"]]
    made["bsdf"] = bsdf(material)
    if "absorption" in material:
        # A color is 1 at most.
        most = max(material["absorption"])
        per_meter = color([value / most for value in material["absorption"]])
        made["interior"] = {"type": "homogeneous", "albedo": 0.0, "sigma_t": per_meter, "scale": most}
    return made


def light_of(light):
    if light["kind"] == "point":
        return {"type": "point", "position": light["position"], "intensity": color(light["intensity"])}
    return {"type": "directional", "direction": light["direction"], "irradiance": color(light["irradiance"])}


def scene_of(spec, options):
    width, height = spec["resolution"]
    camera = spec["camera"]
    absorbs = any("absorption" in material for material in spec["materials"].values())
    to_world = mi.ScalarTransform4f().look_at(camera["origin"], camera["target"], [0, 1, 0])
    scene = {
        "type": "scene",
        "integrator": {"type": "volpath" if absorbs else "path", "max_depth": spec["max_bounces"] + 1, "rr_depth": 100_000},
        "sensor": {
            "type": "perspective", "fov": camera["vfov_deg"], "fov_axis": "y", "to_world": to_world, "near_clip": 1e-3,
            "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
            "sampler": {"type": options.sampler, "sample_count": options.spp},
        },
    }
    for number, shape in enumerate(spec["shapes"]):
        scene[f"shape{number}"] = shape_of(shape, spec["materials"])
    for number, light in enumerate(spec["lights"]):
        scene[f"light{number}"] = light_of(light)
    environment = spec.get("environment")
    if environment and "constant" in environment:
        scene["sky"] = {"type": "constant", "radiance": color(environment["constant"])}
    elif environment:
        sky = "sky-with-sun.exr" if "sun" in json.dumps(environment) else "sky.exr"
        scene["sky"] = {"type": "envmap", "bitmap": mi.Bitmap(str(REFERENCES / sky))}
    return mi.load_dict(scene)


def reference(name):
    bitmap = mi.Bitmap(str(REFERENCES / f"{name}.exr"))
    fields = [field.name for field in bitmap.struct_()]
    values = np.array(bitmap, dtype=np.float64)
    take = lambda prefix: np.stack([values[..., fields.index(prefix + channel)] for channel in "RGB"], -1)
    return take(""), take("se.")


def measure(name, options):
    spec = json.loads((REFERENCES / "specs" / f"{name}.json").read_text())
    # One thread alone waits for itself when it reads an EXR.
    dr.set_thread_count(2)
    scene = scene_of(spec, options)
    expected, errors = reference(name)
    dr.set_thread_count(options.threads)
    times, squares, sums = [], [], []
    for seed in range(PICTURES + 1):
        start = time.perf_counter()
        picture = np.array(mi.render(scene, spp=options.spp, seed=seed), dtype=np.float64)
        if seed:
            times.append(time.perf_counter() - start)
            squares.append(np.mean((picture.clip(None, 10) - expected.clip(None, 10)) ** 2))
            sums.append(picture.sum())
    off = statistics.mean(sums) / expected.sum() - 1
    assert abs(off) < 0.01, f"{name}: the mean is off by {off}"
    median = statistics.median(times)
    error = statistics.mean(squares) - np.mean(errors**2)
    samples = picture.shape[0] * picture.shape[1] * options.spp
    print(json.dumps({
        "engine": f"mitsuba {mi.__version__} {options.variant} {options.sampler}", "scene": name, "spp": options.spp,
        "threads": options.threads, "render_s": median, "msamples_s": samples / median * 1e-6, "error": error,
        "efficiency": 1 / (error * median)}), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--variant", default="scalar_rgb")
    parser.add_argument("--sampler", default="independent")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--spp", type=int, default=64)
    options = parser.parse_args()
    mi.set_variant(options.variant)
    still = (path.stem for path in (REFERENCES / "specs").glob("*.json") if "motion" not in json.loads(path.read_text())["camera"])
    for name in options.scenes or sorted(still):
        measure(name, options)


if __name__ == "__main__":
    main()
