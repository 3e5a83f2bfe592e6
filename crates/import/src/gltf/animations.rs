//! Animations: the numbers of the file as they are at a moment.
//!
//! A channel writes what it comes to into the file's JSON, and the JSON is read anew: a node's translation, rotation, scale and
//! weights are as other numbers are that `KHR_animation_pointer` points to.
//!
//! While the shutter is open nodes move on: their places after each of [`STEPS`] equal steps are kept beside the document.
//!
//! | where the specification leaves a choice | what is done |
//! | --- | --- |
//! | no moment is given | the nodes stand as they do without any animation |
//! | no animation is named | the first |
//! | before the first key and after the last | the value of that key |

use brewster_lanes::math;
use glam::Quat;
use gltf::json::{Index, Value};
use serde::Deserialize;
use serde_json::Map;

use super::document::Document;
use super::nodes::local;
use super::{Found, GltfChoices, Reporter, broken, choose, extensions, typed};
use crate::diagnostics::Code;

#[derive(Deserialize)]
struct Animation {
    name: Option<String>,
    channels: Vec<Channel>,
    samplers: Vec<Sampler>,
}

#[derive(Deserialize)]
struct Channel {
    sampler: usize,
    target: Target,
}

#[derive(Deserialize)]
struct Target {
    node: Option<usize>,
    path: Property,
    extensions: Option<Map<String, Value>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
    Pointer,
}

#[derive(Deserialize)]
struct Sampler {
    input: usize,
    output: usize,
    #[serde(default)]
    interpolation: Interpolation,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Interpolation {
    #[default]
    Linear,
    Step,
    CubicSpline,
}

/// Moves the document to the chosen moment of the chosen animation.
pub(super) fn pose(document: &mut Document, reporter: &mut Reporter, choices: &GltfChoices) -> Found<()> {
    let animations: Vec<Animation> = match &document.animations {
        Value::Null => Vec::new(),
        animations => typed(animations, "animations")?,
    };
    let chosen = match choices.animation.as_deref() {
        Some("all") => (0..animations.len()).collect(),
        Some(chosen) => {
            vec![choose(chosen, animations.iter().map(|animation| animation.name.as_deref()), "animation")?]
        }
        None => (0..animations.len().min(1)).collect(),
    };
    let Some(time) = choices.time else {
        if !animations.is_empty() {
            let message = "no moment of the animations is asked for: nodes stand as they do without them";
            reporter.note(Code::Decision, "animations", message);
        }
        if choices.shutter.is_some() {
            let message = "the shutter opens at no moment: without one nodes stand still";
            reporter.warn(Code::Decision, "", message);
        }
        return Ok(());
    };
    if animations.is_empty() {
        reporter.warn(Code::Decision, "", "a moment is asked for, and the file has no animations");
    }
    let asked = animations.iter().enumerate().filter(|(at, _)| chosen.contains(at));
    let asked: Vec<(usize, &Animation)> = asked.collect();
    if let Some(shutter) = choices.shutter.filter(|&shutter| shutter > 0.0 && !asked.is_empty()) {
        for step in 1..=STEPS {
            write_pose(document, reporter, &asked, time + shutter * (step as f32 / STEPS as f32))?;
            let locals = document.root.nodes.iter().enumerate().map(|(node, of)| local(of, &format!("nodes[{node}]")));
            let locals = locals.collect::<Found<Vec<_>>>()?;
            document.steps.push(locals);
        }
        let is_bent = !document.root.skins.is_empty() || document.root.nodes.iter().any(|node| node.weights.is_some());
        if is_bent {
            let message =
                "nodes move while the shutter is open; skins and morph targets stay as they are when it opens";
            reporter.note(Code::Decision, "animations", message);
        }
    }
    write_pose(document, reporter, &asked, time)
}

/// Steps in which the time of the shutter is looked at.
const STEPS: usize = 16;

/// Moves the document to a moment of some animations, each with its number.
fn write_pose(
    document: &mut Document,
    reporter: &mut Reporter,
    animations: &[(usize, &Animation)],
    time: f32,
) -> Found<()> {
    for &(at, animation) in animations {
        for (number, channel) in animation.channels.iter().enumerate() {
            let path = format!("animations[{at}].channels[{number}]");
            let Some(pointer) = pointer(document, channel, &path)? else { continue };
            let Some(sampler) = animation.samplers.get(channel.sampler) else {
                let message = format!("there is no sampler {}", channel.sampler);
                return Err(broken(format!("{path}.sampler"), message).into());
            };
            let is_rotation = pointer.starts_with("/nodes/") && pointer.ends_with("/rotation");
            let here = format!("animations[{at}].samplers[{}]", channel.sampler);
            let numbers = sample(document, sampler, time, is_rotation, &here)?;
            if !write(&mut document.value, &pointer, &numbers) {
                let message = format!("{pointer:?} points to nothing that could be animated");
                reporter.warn(Code::Gltf, format!("{path}.target"), message);
            }
        }
    }
    document.retype()
}

/// What a channel writes to, as a JSON pointer; nothing for one that extensions give another meaning.
fn pointer(document: &Document, channel: &Channel, path: &str) -> Found<Option<String>> {
    let name = match channel.target.path {
        Property::Translation => "translation",
        Property::Rotation => "rotation",
        Property::Scale => "scale",
        Property::Weights => "weights",
        Property::Pointer => {
            let others = channel.target.extensions.as_ref();
            let found = extensions::fields(others, "KHR_animation_pointer", &format!("{path}.target"))?;
            return found.map(|found| found.need("pointer")).transpose();
        }
    };
    match channel.target.node {
        Some(node) if node >= document.root.nodes.len() => {
            Err(broken(format!("{path}.target.node"), format!("there is no nodes[{node}]")).into())
        }
        node => Ok(node.map(|node| format!("/nodes/{node}/{name}"))),
    }
}

/// The numbers that a sampler gives at a moment.
fn sample(document: &Document, sampler: &Sampler, time: f32, is_rotation: bool, path: &str) -> Found<Vec<f32>> {
    let read = |index: usize, field: &str| {
        let path = format!("{path}.{field}");
        if index >= document.root.accessors.len() {
            return Err(Box::new(broken(path, format!("there is no accessors[{index}]"))));
        }
        Ok(document.gather(Index::new(index as u32), &path)?.numbers())
    };
    let (times, values) = (read(sampler.input, "input")?, read(sampler.output, "output")?);
    let rows = times.len() * if sampler.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    if times.is_empty() || values.len() % rows != 0 || values.is_empty() {
        let message = format!("{} numbers for {} moments", values.len(), times.len());
        return Err(broken(format!("{path}.output"), message).into());
    }
    if let Some(at) = times.windows(2).position(|pair| pair[0].is_nan() || pair[0] >= pair[1]) {
        let message = format!("moment {} is not later than the one before", at + 1);
        return Err(broken(format!("{path}.input"), message).into());
    }
    Ok(interpolated(sampler.interpolation, &times, &values, values.len() / rows, time, is_rotation))
}

/// The row of `width` numbers at a moment between those of the keys.
fn interpolated(
    interpolation: Interpolation,
    times: &[f32],
    values: &[f32],
    width: usize,
    time: f32,
    is_rotation: bool,
) -> Vec<f32> {
    // The last key at or before the moment.
    let key = times.partition_point(|&at| at <= time).saturating_sub(1);
    let is_between = time > times[key] && key + 1 < times.len();
    let span = if is_between { times[key + 1] - times[key] } else { 1.0 };
    let t = if is_between { (time - times[key]) / span } else { 0.0 };
    let row = |row: usize| &values[row * width..][..width];
    let mut found = match interpolation {
        Interpolation::Step => row(key).to_vec(),
        Interpolation::Linear if t == 0.0 => row(key).to_vec(),
        Interpolation::Linear if is_rotation && width == 4 => slerp(row(key), row(key + 1), t),
        Interpolation::Linear => row(key).iter().zip(row(key + 1)).map(|(a, b)| (1.0 - t) * a + t * b).collect(),
        // Each key is an arriving tangent, a value and a leaving tangent.
        Interpolation::CubicSpline if t == 0.0 => row(3 * key + 1).to_vec(),
        Interpolation::CubicSpline => {
            let (t2, t3) = (t * t, t * t * t);
            let weights =
                [2.0 * t3 - 3.0 * t2 + 1.0, span * (t3 - 2.0 * t2 + t), 3.0 * t2 - 2.0 * t3, span * (t3 - t2)];
            let rows = [row(3 * key + 1), row(3 * key + 2), row(3 * key + 4), row(3 * key + 3)];
            (0..width).map(|at| weights.iter().zip(rows).map(|(weight, row)| weight * row[at]).sum()).collect()
        }
    };
    if is_rotation && width == 4 {
        let length = found.iter().map(|x| x * x).sum::<f32>().sqrt();
        if length > 0.0 {
            found.iter_mut().for_each(|x| *x /= length);
        }
    }
    found
}

/// Along the shorter arc between two rotations.
fn slerp(a: &[f32], b: &[f32], t: f32) -> Vec<f32> {
    let (a, b) = (Quat::from_slice(a), Quat::from_slice(b));
    let cosine = a.dot(b);
    let b = if cosine < 0.0 { -b } else { b };
    let angle = math::acos(cosine.abs().min(1.0));
    let sine = math::sin(angle);
    let mixed = match sine > 1e-4 {
        true => a * (math::sin((1.0 - t) * angle) / sine) + b * (math::sin(t * angle) / sine),
        false => a * (1.0 - t) + b * t,
    };
    mixed.to_array().to_vec()
}

/// The weights of a node's or a mesh's morph targets where it has none of its own: the mesh's, otherwise zeros.
fn weights_of(root: &Value, owner: &str) -> Option<Value> {
    let owner = root.pointer(owner)?;
    let mesh = owner.get("mesh").map_or(Some(owner), |mesh| root.pointer(&format!("/meshes/{mesh}")))?;
    let targets = || mesh.pointer("/primitives/0/targets")?.as_array();
    mesh.get("weights").cloned().or_else(|| Some(vec![0.0; targets()?.len()].into()))
}

/// Writes numbers where a JSON pointer leads: a number, a yes or no, or a list. A member that is not there is made.
fn write(root: &mut Value, pointer: &str, numbers: &[f32]) -> bool {
    let Some((parent, name)) = pointer.rsplit_once('/') else { return false };
    let number = |number: f32| Value::from(f64::from(number));
    let is_flag = name == "visible";
    let value = match numbers {
        [flag] if is_flag => Value::from(*flag != 0.0),
        [one] if name != "weights" => number(*one),
        many => many.iter().copied().map(number).collect(),
    };
    if name.parse::<usize>().is_ok() && root.pointer(parent).is_none() {
        // Weights are the only list with defaults whose rows are animated one by one.
        let of = |owner| Some((weights_of(root, owner)?, owner));
        let Some((weights, owner)) = parent.strip_suffix("/weights").and_then(of) else { return false };
        if let Some(Value::Object(owner)) = root.pointer_mut(owner) {
            owner.insert("weights".into(), weights);
        }
    }
    // What has its defaults may be absent, with the objects that it stands in.
    let Some(parent) = make_way(root, parent) else { return false };
    match parent {
        Value::Object(object) => {
            if name != "matrix" {
                object.insert(name.to_owned(), value);
            }
            true
        }
        Value::Array(rows) => match name.parse::<usize>().ok().and_then(|at| rows.get_mut(at)) {
            Some(row) => {
                *row = value;
                true
            }
            None => false,
        },
        _ => false,
    }
}

/// The value at a pointer, with empty objects in the place of absent ones below the second level: `/materials/3` has to be there.
fn make_way<'v>(root: &'v mut Value, pointer: &str) -> Option<&'v mut Value> {
    pointer.split('/').skip(1).enumerate().try_fold(root, |value, (depth, key)| match value {
        Value::Array(rows) => rows.get_mut(key.parse::<usize>().ok()?),
        Value::Object(object) if depth < 2 && !object.contains_key(key) => None,
        Value::Object(object) => Some(object.entry(key).or_insert_with(|| Value::Object(Map::new()))),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostics::Diagnostic;
    use crate::gltf::testing::{Builder, document};

    fn check(found: &[f32], expected: &[f32], what: &str) {
        let close = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5);
        assert!(close, "{what}: {found:?} for {expected:?}");
    }

    /// A file at the moment that is chosen, and what is said of it.
    fn posed(builder: &Builder, choices: &GltfChoices) -> Found<(Document, Vec<Diagnostic>)> {
        let (mut document, mut reporter) = (document(builder), Reporter::new(""));
        pose(&mut document, &mut reporter, choices).map(|()| (document, reporter.said))
    }

    #[test]
    fn values_lie_between_keys_as_the_specification_says() {
        let times = [1.0, 2.0, 4.0];
        let values = [0.0, 10.0, 20.0, 30.0, 40.0, 10.0];
        for (time, step, linear) in [
            (0.0, [0.0, 10.0], [0.0, 10.0]),
            (1.0, [0.0, 10.0], [0.0, 10.0]),
            (1.25, [0.0, 10.0], [5.0, 15.0]),
            (2.0, [20.0, 30.0], [20.0, 30.0]),
            (3.0, [20.0, 30.0], [30.0, 20.0]),
            (9.0, [40.0, 10.0], [40.0, 10.0]),
        ] {
            let at = |interpolation| interpolated(interpolation, &times, &values, 2, time, false);
            check(&at(Interpolation::Step), &step, "step");
            check(&at(Interpolation::Linear), &linear, "linear");
        }
    }

    #[test]
    fn splines_are_hermite_splines_with_tangents_in_time() {
        // Through x(1) = 1 with slope 2 and x(3) = 5 with slope -1; Hermite's polynomials at the middle are 1/2, 1/8, 1/2, -1/8,
        // the slopes count by the two seconds between: 0.5 + 0.125 * 4 + 2.5 + 0.125 * 2.
        let found =
            interpolated(Interpolation::CubicSpline, &[1.0, 3.0], &[9.0, 1.0, 2.0, -1.0, 5.0, 9.0], 1, 2.0, false);
        check(&found, &[0.5 + 0.5 + 2.5 + 0.25], "the middle");
        for (time, expected) in [(0.0, 1.0), (1.0, 1.0), (3.0, 5.0), (7.0, 5.0)] {
            let values = [9.0, 1.0, 2.0, -1.0, 5.0, 9.0];
            check(
                &interpolated(Interpolation::CubicSpline, &[1.0, 3.0], &values, 1, time, false),
                &[expected],
                "a key",
            );
        }
    }

    #[test]
    fn rotations_take_the_shorter_arc_at_even_speed() {
        // From no turn to a quarter turn about z, which is stored negated: a third of the way is 30 degrees.
        let (half, sixth) = (std::f32::consts::FRAC_PI_4, std::f32::consts::PI / 12.0);
        let values = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -half.sin(), -half.cos()];
        let found = interpolated(Interpolation::Linear, &[0.0, 3.0], &values, 4, 1.0, true);
        check(&found, &[0.0, 0.0, sixth.sin(), sixth.cos()], "30 degrees");
    }

    #[test]
    fn channels_move_nodes_and_whatever_is_pointed_to() {
        let mut builder = Builder::default();
        let times = builder.floats(&[0.0, 1.0], "SCALAR");
        let places = builder.floats(&[0.0, 0.0, 0.0, 2.0, 4.0, 6.0], "VEC3");
        let factors = builder.floats(&[0.0, 1.0], "SCALAR");
        builder.rest = format!(
            r#","nodes":[{{}}],"materials":[{{}}],"animations":[{{"name":"go","samplers":[
            {{"input":{times},"output":{places}}},{{"input":{times},"output":{factors}}}],"channels":[
            {{"sampler":0,"target":{{"node":0,"path":"translation"}}}},
            {{"sampler":1,"target":{{"path":"pointer","extensions":{{"KHR_animation_pointer":
            {{"pointer":"/materials/0/pbrMetallicRoughness/roughnessFactor"}}}}}}}}]}}]"#
        );
        let choices = GltfChoices { time: Some(0.25), animation: Some("go".into()), ..GltfChoices::default() };
        let (document, _) = posed(&builder, &choices).expect("it can be animated");
        assert_eq!(document.root.nodes[0].translation, Some([0.5, 1.0, 1.5]));
        assert_eq!(document.root.materials[0].pbr_metallic_roughness.roughness_factor.0, 0.25);
        let unknown = GltfChoices { animation: Some("goo".into()), ..choices };
        let error = posed(&builder, &unknown).err().expect("no such animation");
        assert_eq!(error.help.as_deref(), Some("did you mean \"go\"?"));
    }

    /// The asset object model: lists of weights are as long as there are targets, whether they are written or not.
    #[test]
    fn single_weights_are_set_where_none_are_written() {
        let mut builder = Builder::default();
        let times = builder.floats(&[0.0, 1.0], "SCALAR");
        let values = builder.floats(&[0.0, 1.0], "SCALAR");
        let positions = builder.floats(&[0.0; 9], "VEC3");
        let primitive = format!(
            r#"{{"attributes":{{"POSITION":{positions}}},"targets":[{{"POSITION":{positions}}},{{"POSITION":{positions}}}]}}"#
        );
        for (weights, pointer, of_node, of_mesh) in [
            ("", "/nodes/0/weights/1", Some(vec![0.0, 0.25]), None),
            (r#","weights":[0.5,0.75]"#, "/nodes/0/weights/1", Some(vec![0.5, 0.25]), Some(vec![0.5, 0.75])),
            ("", "/meshes/0/weights/0", None, Some(vec![0.25, 0.0])),
            ("", "/meshes/0/weights/2", None, Some(vec![0.0, 0.0])),
            ("", "/nodes/1/weights/0", None, None),
            ("", "/nodes/0/translation/1", None, None),
        ] {
            builder.rest = format!(
                r#","nodes":[{{"mesh":0}},{{}}],"meshes":[{{"primitives":[{primitive}]{weights}}}],"animations":[{{
                "samplers":[{{"input":{times},"output":{values}}}],"channels":[{{"sampler":0,"target":{{"path":"pointer",
                "extensions":{{"KHR_animation_pointer":{{"pointer":"{pointer}"}}}}}}}}]}}]"#
            );
            let choices = GltfChoices { time: Some(0.25), ..GltfChoices::default() };
            let (document, _) = posed(&builder, &choices).unwrap_or_else(|error| panic!("{pointer}: {error}"));
            let found = (&document.root.nodes[0].weights, &document.root.meshes[0].weights);
            assert_eq!(found, (&of_node, &of_mesh), "{pointer} beside {weights:?}");
        }
    }

    /// Two meters a second along x: half a second later one meter farther, in sixteen even steps.
    #[test]
    fn nodes_move_on_while_the_shutter_is_open() {
        let mut builder = Builder::default();
        let times = builder.floats(&[0.0, 1.0], "SCALAR");
        let places = builder.floats(&[0.0, 0.0, 0.0, 2.0, 4.0, 6.0], "VEC3");
        builder.rest = format!(
            r#","nodes":[{{}}],"animations":[{{"samplers":[{{"input":{times},"output":{places}}}],
            "channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}]}}]"#
        );
        let at = |time, shutter| {
            let choices = GltfChoices { time, shutter, ..GltfChoices::default() };
            posed(&builder, &choices).expect("it can be animated")
        };
        let (document, _) = at(Some(0.25), Some(0.5));
        assert_eq!(document.root.nodes[0].translation, Some([0.5, 1.0, 1.5]));
        let along: Vec<f32> = document.steps.iter().map(|step| step[0].translation.x).collect();
        assert_eq!(along, (1..=16).map(|step| 0.5 + step as f32 / 16.0).collect::<Vec<_>>());
        assert!(at(Some(0.25), None).0.steps.is_empty());
        let (document, said) = at(None, Some(0.5));
        assert!(document.steps.is_empty());
        assert!(said.iter().any(|said| said.message.contains("at no moment")), "{said:?}");
    }
}
