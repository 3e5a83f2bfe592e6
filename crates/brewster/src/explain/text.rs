//! An explanation as text: a tree for a terminal, narrower than 120 columns.

use std::fmt::Write;

use super::{Explanation, channels, clipped, short};
use crate::explain::{ExplainedSample, NamedFresnel, NamedLayer, NamedLight, NamedRay, NamedSurface};

/// Levels beyond which a tree is not moved further to the right.
const MOST_LEVELS: usize = 20;

/// Characters of a name.
const NAME: usize = 28;

impl Explanation {
    /// As text.
    pub fn text(&self) -> String {
        let mut text = format!("{}\n", clipped(&self.title(), 110));
        let what = self.what();
        let [r, g, b] = self.units;
        push(&mut text, format_args!("radiance {}, {what}", channels(self.radiance)));
        push(&mut text, format_args!("sum {r} {g} {b} in units of 2^-32"));
        for sample in &self.samples {
            let [r, g, b] = sample.units;
            push(
                &mut text,
                format_args!("\nsample {}: {} = {r} {g} {b} units", sample.number, channels(sample.radiance)),
            );
            if sample.rejected > 0 {
                push(&mut text, format_args!("{} contributions are no light and left out", sample.rejected));
            }
            write_ray(&mut text, (sample, &sample.children()), 0, &mut Vec::new());
        }
        text
    }
}

fn push(text: &mut String, line: std::fmt::Arguments<'_>) {
    writeln!(text, "{line}").expect("a string takes all that is written");
}

/// Writes a ray and what it sent; `lasts` tells for the rays on the way to it whether they are the last of their parent.
fn write_ray(
    text: &mut String,
    (sample, families): (&ExplainedSample, &[Vec<usize>]),
    number: usize,
    lasts: &mut Vec<bool>,
) {
    let (ray, children) = (&sample.rays[number], &families[number]);
    let beyond = lasts.len().saturating_sub(MOST_LEVELS);
    let mut before: String = lasts
        .iter()
        .take(lasts.len().saturating_sub(1))
        .skip(beyond)
        .map(|last| if *last { "   " } else { "│  " })
        .collect();
    let branch = match lasts.last() {
        None => "",
        Some(true) => "└─ ",
        Some(false) => "├─ ",
    };
    push(text, format_args!("{before}{branch}{}", ray.heading()));
    before += match lasts.last() {
        None => "",
        Some(true) => "   ",
        Some(false) => "│  ",
    };
    let bar = if children.is_empty() { "   " } else { "│  " };
    for line in ray.lines() {
        push(text, format_args!("{before}{bar}{line}"));
    }
    for (place, &child) in children.iter().enumerate() {
        lasts.push(place + 1 == children.len());
        write_ray(text, (sample, families), child, lasts);
        lasts.pop();
    }
}

impl ExplainedSample {
    /// The rays that each ray sent, in their order.
    pub(super) fn children(&self) -> Vec<Vec<usize>> {
        let mut families = vec![Vec::new(); self.rays.len()];
        for (number, ray) in self.rays.iter().enumerate() {
            if let Some(parent) = ray.parent {
                families[parent].push(number);
            }
        }
        families
    }
}

impl NamedRay {
    /// Queue, depth and weight.
    pub(super) fn heading(&self) -> String {
        let name = if self.parent.is_none() { "camera ray" } else { self.queue };
        format!("{name}, depth {}, weight {}", self.depth, channels(self.weight))
    }

    /// All else.
    pub(super) fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let medium = format!("in {} {}", clipped(&self.medium.name, NAME), short(self.medium.ior.into()));
        let way = self.distance.map_or("without end".to_owned(), |distance| format!("{} m", short(distance.into())));
        lines.push(format!("{way} {medium}"));
        if self.transmittance != [1.0; 3] {
            lines.push(format!("Beer {} leaves weight {}", channels(self.transmittance), channels(self.weight_there)));
        }
        if let Some(wavelength) = self.wavelength {
            lines.push(format!("at {} nm", short(wavelength.into())));
        }
        if self.passed > 0 {
            lines.push(format!(
                "through {} that chance left out",
                if self.passed == 1 { "a surface" } else { "surfaces" }
            ));
        }
        match (&self.surface, self.met) {
            (Some(surface), "surface") => lines.extend(surface.lines()),
            (Some(surface), _) => {
                lines.push(format!("crosses {}, which is no boundary there", clipped(&surface.entity, NAME)))
            }
            (None, "medium") => lines.push("is scattered".to_owned()),
            (None, _) => lines.push("meets nothing".to_owned()),
        }
        lines.extend(self.ends.iter().map(|end| (*end).to_owned()));
        lines.extend(self.lights.iter().map(NamedLight::line));
        lines
    }
}

impl NamedSurface {
    pub(super) fn lines(&self) -> Vec<String> {
        let [x, y, z] = self.position.map(|place| short(place.into()));
        let kind = self.kind.filter(|kind| !self.material.contains(kind));
        let kind = kind.map_or(String::new(), |kind| format!(", {kind}"));
        let mut lines =
            vec![format!("meets {} of {}{kind}", clipped(&self.entity, NAME), clipped(&self.material, NAME))];
        let cosine = self.cosine.map_or(String::new(), |cosine| format!(", cos θ {}", short(cosine.into())));
        lines.push(format!("at {x} {y} {z}{cosine}"));
        if let Some([front, behind]) = &self.media {
            let name = |name: &str| clipped(name, NAME / 2);
            let (from, to) = (short(front.ior.into()), short(behind.ior.into()));
            lines.push(format!("from {} {from} to {} {to}", name(&front.name), name(&behind.name)));
        }
        lines.extend(self.fresnel.iter().flat_map(NamedFresnel::lines));
        lines.extend(self.layers.iter().flat_map(NamedLayer::lines));
        lines
    }
}

impl NamedLayer {
    pub(super) fn lines(&self) -> impl Iterator<Item = String> {
        self.fresnel.lines().into_iter().map(|line| format!("{}: {line}", self.name))
    }
}

impl NamedFresnel {
    pub(super) fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let (Some(eta), Some(k)) = (self.eta_t, self.k) {
            lines.push(format!("η {}, k {}", channels(eta), channels(k)));
        }
        if let (Some(s), Some(p)) = (self.r_s, self.r_p) {
            lines.push(format!("R_s {}, R_p {}", channels(s), channels(p)));
        }
        let model = if self.model == "Exact" { String::new() } else { format!(" by {}", self.model) };
        let rough = if self.alpha > 0.0 { format!(", rough: α {}", short(self.alpha.into())) } else { String::new() };
        let total = if self.total { ", total" } else { "" };
        lines.push(format!("F_r {}, F_t {}{model}{total}{rough}", channels(self.f_r), channels(self.f_t)));
        lines
    }
}

impl NamedLight {
    pub(super) fn line(&self) -> String {
        let name = self.name.as_ref().map(|name| clipped(name, NAME));
        let from = match (self.by, name) {
            ("light", Some(name)) => format!("from {name}"),
            ("emitter", Some(name)) => format!("sent out by {name}"),
            ("background", _) => "from the background".to_owned(),
            ("surface", _) => "from all around".to_owned(),
            (by, _) => by.to_owned(),
        };
        match (self.visible, self.film()) {
            (false, _) => format!("  nothing {from}: {} is stopped", channels(self.radiance)),
            (true, None) => format!("  {} {from} is no light", channels(self.radiance)),
            (true, Some(light)) => format!("+ {} {from}", channels(light)),
        }
    }
}
