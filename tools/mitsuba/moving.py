"""The reference pictures of moving scenes, by Mitsuba 3, which knows no motion blur of shapes: the mean over many moments of the shutter.

    pip install mitsuba
    python tools/mitsuba/moving.py moving-things FILE.exr [--runs 16] [--moments 64] [--spp 8] [--variant scalar_rgb] [--threads 2]

Builds tests/references/specs/NAME.json at every moment with the same means as speed.py. The shutter's time is cut into as many equal parts as
there are runs times moments, and the scene is rendered in the middle of each, with a seed of its own. Of as many neighboring parts as there are runs
each run gets one, which is drawn with a fixed seed. Writes the mean over the runs and its standard error, from how they differ.

Motion, as crates/import/README.md has it, and how it is interpolated, as crates/geometry/src/motion.rs has it, for matrices of columns:

- `motion` of a shape, light or group after a part s of the time: translate(translate + s by) · rotate · R(s) · scale · (1 + s (scale' - 1)). R(s)
  is the product of the motion's rotations by s times their angles, `scale'` the motion's scale.
- That holds at keys, as many equal steps as bring the turn of a step below 0.0894 radians, rounded up to a power of two. Between keys
  matrices are interpolated, so that what turns goes along chords.
- What is `in` a group goes along with it. It has keys where either of the two does.
- The camera's `motion` says where `origin` and `target` are in the end; both go evenly.
"""
import argparse
import copy
import json
import math

import drjit as dr
import mitsuba as mi
import numpy as np

from speed import REFERENCES, scene_of

# 1 - cos(step / 2) stays below a thousandth.
WIDEST_STEP = 0.0894


def translation(by):
    matrix = np.eye(4)
    matrix[:3, 3] = by
    return matrix


def scaling(factors):
    return np.diag([*factors, 1.0])


def rotation(turns, part=1.0):
    """The first turn is the outermost."""
    product = np.eye(4)
    for axis, degrees in turns:
        x, y, z = np.array(axis) / np.linalg.norm(axis)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        angle = math.radians(degrees) * part
        turn = np.eye(4)
        # Rodrigues.
        turn[:3, :3] += math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
        product = product @ turn
    return product


def steps_of(angle):
    return 2 ** math.ceil(math.log2(max(1.0, angle / WIDEST_STEP)))


def interpolated(keys, part):
    if len(keys) == 1:
        return keys[0]
    steps = len(keys) - 1
    step = min(int(part * steps), steps - 1)
    return keys[step] + (keys[step + 1] - keys[step]) * (part * steps - step)


def own_keys(node):
    """The keys of a shape, light or group in the space that it is in; one where it does not move."""
    motion = node.get("motion", {})
    turns, growth = motion.get("rotate", []), motion.get("scale", 1) - 1

    def at(part):
        at_first = np.array(node.get("translate", [0, 0, 0]))
        place = translation(at_first + part * np.array(motion.get("by", [0, 0, 0]))) @ rotation(node.get("rotate", []))
        return place @ rotation(turns, part) @ scaling(np.array(node.get("scale", [1, 1, 1])) * (1 + part * growth))

    steps = steps_of(sum(abs(math.radians(angle)) for _, angle in turns)) if motion else 0
    return [at(step / max(steps, 1)) for step in range(steps + 1)]


def world_keys(node, groups):
    own = own_keys(node)
    if "in" not in node:
        return own
    above = own_keys(groups[node["in"]])
    # Powers of two: the larger number of steps is a multiple of the other.
    steps = max(len(own), len(above)) - 1
    return [interpolated(above, step / max(steps, 1)) @ interpolated(own, step / max(steps, 1)) for step in range(steps + 1)]


def on_the_way(camera, name, part):
    start = np.array(camera[name], float)
    return start + part * (np.array(camera.get("motion", {}).get(name, start)) - start)


class Moving:
    """A scene whose places depend on the time."""

    def __init__(self, spec):
        self.spec = spec
        groups = spec.get("groups", {})
        self.shapes = [world_keys(shape, groups) for shape in spec["shapes"]]
        self.lights = [world_keys(light, groups) for light in spec["lights"]]

    def at(self, part):
        """The description of the scene as it stands after a part of the time."""
        spec = copy.deepcopy(self.spec)
        spec["camera"] |= {name: on_the_way(self.spec["camera"], name, part).tolist() for name in ("origin", "target")}
        for shape, keys in zip(spec["shapes"], self.shapes):
            shape["matrix"] = interpolated(keys, part)
        for light, keys in zip(spec["lights"], self.lights):
            light["position"] = [float(x) for x in interpolated(keys, part)[:3] @ [*light["position"], 1.0]]
        return spec


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("file")
    parser.add_argument("--runs", type=int, default=16)
    parser.add_argument("--moments", type=int, default=64)
    parser.add_argument("--spp", type=int, default=8)
    parser.add_argument("--sampler", default="independent")
    parser.add_argument("--variant", default="scalar_rgb")
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    mi.set_variant(options.variant)
    dr.set_thread_count(options.threads)
    moving = Moving(json.loads((REFERENCES / "specs" / f"{options.scene}.json").read_text()))
    # For every row of neighboring parts of the time, which of them belongs to which run.
    shares = np.random.default_rng(1).permuted(np.tile(np.arange(options.runs), (options.moments, 1)), axis=1)
    runs = []
    for run in range(options.runs):
        total = 0.0
        for moment in range(options.moments):
            part = (moment + (shares[moment, run] + 0.5) / options.runs) / options.moments
            scene = scene_of(moving.at(part), options)
            picture = mi.render(scene, spp=options.spp, seed=run * options.moments + moment)
            total = total + np.array(picture, dtype=np.float64)
        runs.append(total / options.moments)
        print(f"run {run + 1} of {options.runs}: mean {runs[-1].mean():.6f}", flush=True)
    error = np.std(runs, axis=0, ddof=1) / math.sqrt(options.runs)
    values = np.concatenate([np.mean(runs, axis=0), error], axis=-1).astype(np.float32)
    mi.Bitmap(values, channel_names=["R", "G", "B", "se.R", "se.G", "se.B"]).write(options.file)


main()
