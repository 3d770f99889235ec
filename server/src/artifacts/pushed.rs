//! Movable objects in the coverage picture: where they are, where they began, and the way between.

use arenas::Movable;
use swarm::methods::Explores;
use swarm::run::Tracks;
use swarm::world::ObjectPose;

use super::palette::{Colour, OBJECT, OBJECT_START, WHITE};
use super::scene::Item;
use crate::documents::ResolvedRun;

const SIDES_OF_A_DISC: u32 = 24;

/// A movable object as the picture shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Pushed {
    start: ObjectPose,
    /// Where it is.
    pub pose: ObjectPose,
    /// Where its centre was: from where it began, or from where it was put back to when its last
    /// epoch began, to where it is. Metres.
    pub way_m: Vec<[f32; 2]>,
    half_sides_m: Option<[f64; 2]>,
    reach_m: f64,
}

impl Pushed {
    fn new(object: &Movable) -> Self {
        let start = ObjectPose::of(object);
        Self {
            start,
            pose: start,
            way_m: vec![[start.x_m, start.y_m]],
            half_sides_m: object.half_sides_m(),
            reach_m: object.reach_m(),
        }
    }

    fn go_to(&mut self, pose: ObjectPose) {
        self.pose = pose;
        let place = [pose.x_m, pose.y_m];
        if self.way_m.last() != Some(&place) {
            self.way_m.push(place);
        }
    }

    fn outline(&self, pose: &ObjectPose, at: &impl Fn(f64, f64) -> [f32; 2]) -> Vec<[f32; 4]> {
        let corners: Vec<[f64; 2]> = match self.half_sides_m {
            Some([a, b]) => vec![[-a, -b], [a, -b], [a, b], [-a, b]],
            None => (0..SIDES_OF_A_DISC)
                .map(|side| {
                    let share = f64::from(side) / f64::from(SIDES_OF_A_DISC);
                    let (sin, cos) = libm::sincos(std::f64::consts::TAU * share);
                    [self.reach_m * cos, self.reach_m * sin]
                })
                .collect(),
        };
        let ObjectPose { x_m, y_m, cos, sin } = *pose;
        let [x_m, y_m, cos, sin] = [x_m, y_m, cos, sin].map(f64::from);
        let corner = |[along, across]: [f64; 2]| {
            at(
                x_m + cos * along - sin * across,
                y_m + sin * along + cos * across,
            )
        };
        let corners: Vec<[f32; 2]> = corners.into_iter().map(corner).collect();
        let next = corners.iter().cycle().skip(1);
        let sides = corners.iter().zip(next);
        sides
            .map(|([x1, y1], [x2, y2])| [*x1, *y1, *x2, *y2])
            .collect()
    }
}

/// The movable objects of a run. Where epochs put objects back, their way is that of the last one.
pub fn pushed(spec: &ResolvedRun, tracks: &Tracks) -> Vec<Pushed> {
    let mut objects: Vec<Pushed> = spec.arena().objects().iter().map(Pushed::new).collect();
    let run = spec.run_spec();
    let epoch_steps = u64::from(run.steps_per_epoch);
    let last = tracks.moments().next_back().map_or(0, |last| last.steps);
    let evolving = run.controller.method.definition().explores == Explores::Evolving;
    let resets = run.episodes.reset(evolving);
    let began = if resets {
        last.saturating_sub(1) / epoch_steps * epoch_steps
    } else {
        0
    };
    let shown = |steps| steps > began || !resets;
    for moment in tracks.moments().filter(|moment| shown(moment.steps)) {
        for (object, sample) in objects.iter_mut().zip(moment.objects) {
            object.go_to(sample.pose);
        }
    }
    objects
}

/// Draws them; `at` gives pixels for metres.
pub fn draw(items: &mut Vec<Item>, objects: &[Pushed], at: impl Fn(f64, f64) -> [f32; 2]) {
    if objects.is_empty() {
        return;
    }
    let moved = || objects.iter().filter(|object| object.pose != object.start);
    let starts = moved().flat_map(|object| object.outline(&object.start, &at));
    lines(items, starts.collect(), 1.5, OBJECT_START);
    let ways = objects.iter().flat_map(|object| object.way_m.windows(2));
    let way = |pair: &[[f32; 2]]| {
        let [[x1, y1], [x2, y2]] =
            [pair[0], pair[1]].map(|[x_m, y_m]| at(f64::from(x_m), f64::from(y_m)));
        [x1, y1, x2, y2]
    };
    edged(items, ways.map(way).collect(), 1.5);
    let now = objects
        .iter()
        .flat_map(|object| object.outline(&object.pose, &at));
    edged(items, now.collect(), 3.0);
}

/// An object in the legend, left and base line in pixels.
pub fn draw_now_mark(items: &mut Vec<Item>, [left, y]: [f32; 2]) {
    edged(items, square([left + 7.0, y - 13.0]), 3.0);
}

/// Where an object began, and a way, in the legend.
pub fn draw_start_mark(items: &mut Vec<Item>, [left, y]: [f32; 2]) {
    lines(items, square([left, y - 13.0]), 1.5, OBJECT_START);
    edged(
        items,
        vec![[left + 8.0, y - 5.0, left + 30.0, y - 5.0]],
        1.5,
    );
}

fn square([left, top]: [f32; 2]) -> Vec<[f32; 4]> {
    let (right, bottom) = (left + 16.0, top + 16.0);
    vec![
        [left, top, right, top],
        [right, top, right, bottom],
        [right, bottom, left, bottom],
        [left, bottom, left, top],
    ]
}

/// On a white edge, so that lines stand out from every colour of squares.
fn edged(items: &mut Vec<Item>, edges: Vec<[f32; 4]>, width_px: f32) {
    lines(items, edges.clone(), width_px + 2.0, WHITE);
    lines(items, edges, width_px, OBJECT);
}

fn lines(items: &mut Vec<Item>, lines: Vec<[f32; 4]>, width_px: f32, colour: Colour) {
    if !lines.is_empty() {
        items.push(Item::Lines {
            lines,
            width_px,
            colour,
        });
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::artifacts::coverage_svg;
    use crate::documents::testing::yard;
    use crate::documents::{BuiltinArenas, resolve};
    use swarm::run::Run;

    /// What is drawn after three epochs of 2,000 steps, and the run.
    fn after_three_epochs(episodes: &str) -> (Vec<Pushed>, Run, String) {
        let spec = serde_json::json!({
            "engine": "rapier", "episodes": episodes, "robots": 4, "placement": "random",
            "controller": { "method": "brownian" }, "epochs": 3,
            "arena": yard()
        });
        let spec = resolve(&spec, &BuiltinArenas).unwrap();
        let mut run = Run::new(spec.run_spec()).unwrap();
        run.advance(u64::MAX);
        let objects = pushed(&spec, &run.tracks());
        let svg = coverage_svg(spec.arena(), &run.visits(), None, &objects);
        (objects, run, svg)
    }

    #[test]
    fn ways_go_from_the_start_to_the_last_pose() {
        for (episodes, most) in [("reset", 11), ("continue", 31)] {
            let (objects, run, svg) = after_three_epochs(episodes);
            for (object, end) in objects.iter().zip(run.objects()) {
                assert_eq!(object.pose, end.pose);
                let ends = [object.way_m[0], *object.way_m.last().unwrap()];
                let [first, last] = [object.start, end.pose].map(|pose| [pose.x_m, pose.y_m]);
                assert_eq!(ends, [first, last]);
                // Each epoch has ten moments.
                assert!(object.way_m.len() <= most, "{episodes}");
                let chords = object.way_m.windows(2).map(|pair| {
                    f64::from((pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
                });
                assert!(chords.sum::<f64>() <= end.moved_m + 1e-3);
            }
            assert!(objects.iter().any(|object| object.way_m.len() > 2));
            for words in ["movable object", "its start and way", "#b00084", "#e896d2"] {
                assert!(svg.contains(words), "{words}");
            }
        }
    }

    #[test]
    fn outlines_turn_with_their_objects() {
        let (mut objects, ..) = after_three_epochs("continue");
        let at = |x: f64, y: f64| [x as f32, y as f32];
        let object = &mut objects[0];
        let pose = ObjectPose {
            x_m: 0.3,
            y_m: 0.2,
            cos: 0.0,
            sin: 1.0,
        };
        let sides = object.outline(&pose, &at);
        assert_eq!(sides.len(), 4);
        for [x, y, ..] in sides {
            assert!(((x - 0.3).abs() - 0.02).abs() < 1e-6 && ((y - 0.2).abs() - 0.03).abs() < 1e-6);
        }
        let circle = objects[1].outline(&pose, &at);
        for [x1, y1, x2, y2] in circle {
            assert!(((x1 - 0.3).hypot(y1 - 0.2) - 0.03).abs() < 1e-6);
            assert!((x2 - x1).hypot(y2 - y1) < 0.01);
        }
    }
}
