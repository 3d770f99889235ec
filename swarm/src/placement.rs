//! Start poses: from the arena, on a grid around its first start, or at random; never overlapping,
//! and where a start pose can reach unless it may be anywhere.

use arenas::index::WallIndex;
use arenas::{Arena, Movable, Pose, WithinReach};

use crate::bodies::StartPose;
use crate::random::{Purpose, Site, Stream, stream_key};
use crate::robot::RobotModel;
use crate::spec::{FieldError, Placement};

/// Room between two bodies, and between a body and a wall, at the start, metres.
const ROOM_M: f64 = 1e-3;

/// Stands for no body: there are never so many.
const NOBODY: u32 = u32::MAX;

/// Attempts a robot before random placement gives up.
const ATTEMPTS: u32 = 2_000;

fn start_pose(x_m: f64, y_m: f64, heading_rad: f64) -> StartPose {
    StartPose {
        x_m: x_m as f32,
        y_m: y_m as f32,
        cos: libm::cos(heading_rad) as f32,
        sin: libm::sin(heading_rad) as f32,
    }
}

fn refuse(message: String, allowed: String) -> FieldError {
    FieldError {
        pointer: "/robots".into(),
        message,
        allowed,
    }
}

/// The start poses of `robots` robots.
///
/// # Errors
/// When they do not fit; says how many do.
pub fn place(
    arena: &Arena,
    model: &RobotModel,
    index: &WallIndex,
    placement: Placement,
    robots: u32,
    seed: u64,
    site: Site,
) -> Result<Vec<StartPose>, FieldError> {
    let wanted = robots as usize;
    let within = || {
        // The first robot of a grid stands at the first start pose.
        let asked = !placement.is_anywhere() && (wanted > 1 || placement == Placement::Random);
        asked.then(|| WithinReach::new(arena, model.parameters.body_radius_m, ROOM_M))
    };
    let poses = match placement {
        Placement::Start => {
            enough_starts(arena, robots)?;
            let poses = arena.starts();
            if let Some((a, b)) = overlapping(&poses[..wanted], model.parameters.body_radius_m) {
                return Err(refuse(
                    format!(
                        "the robots of start poses {a} and {b} of the arena {} would overlap",
                        arena.name()
                    ),
                    format!(
                        "at most {b} robots with placement `start`: its start poses before that are \
                         two body radii apart"
                    ),
                ));
            }
            poses[..wanted]
                .iter()
                .map(|p| start_pose(p.x_m, p.y_m, p.heading_rad))
                .collect()
        }
        Placement::Grid | Placement::GridAnywhere => {
            let room = Room::new(arena, index, model, within());
            grid(&room, wanted)
        }
        Placement::Random | Placement::RandomAnywhere => {
            let room = Room::new(arena, index, model, within());
            random(&room, wanted, seed, site)
        }
    };
    if poses.len() < wanted {
        return Err(refuse(
            format!("{robots} robots do not fit into the arena {}", arena.name()),
            format!(
                "at most {} robots with placement `{}`",
                poses.len(),
                placement.kind()
            ),
        ));
    }
    Ok(poses)
}

/// Whether the arena has a start pose for each robot.
///
/// # Errors
/// When it has fewer; says how many.
pub fn enough_starts(arena: &Arena, robots: u32) -> Result<(), FieldError> {
    let poses = arena.starts().len();
    if poses >= robots as usize {
        return Ok(());
    }
    Err(refuse(
        format!(
            "the arena {} has {poses} start poses for {robots} robots",
            arena.name()
        ),
        format!("at most {poses} robots with placement `start`, or placement `grid` or `random`"),
    ))
}

/// The first start pose nearer than two body radii to one before it, after that one; `None` where
/// all are apart (sweep along x).
fn overlapping(poses: &[Pose], radius_m: f64) -> Option<(usize, usize)> {
    let apart = 2.0 * radius_m;
    let mut first: Option<(usize, usize)> = None;
    let mut order: Vec<usize> = (0..poses.len()).collect();
    order.sort_by(|&a, &b| poses[a].x_m.total_cmp(&poses[b].x_m).then(a.cmp(&b)));
    for (place, &a) in order.iter().enumerate() {
        for &b in &order[place + 1..] {
            let (dx, dy) = (poses[b].x_m - poses[a].x_m, poses[b].y_m - poses[a].y_m);
            if dx >= apart {
                break;
            }
            if dx * dx + dy * dy < apart * apart {
                let (early, late) = (a.min(b), a.max(b));
                if first.is_none_or(|first| (late, early) < (first.1, first.0)) {
                    first = Some((early, late));
                }
            }
        }
    }
    first
}

/// Where bodies can be put.
struct Room<'a> {
    arena: &'a Arena,
    index: &'a WallIndex,
    radius_m: f64,
    /// Where a start pose reaches; anywhere without.
    within: Option<WithinReach>,
}

impl<'a> Room<'a> {
    fn new(
        arena: &'a Arena,
        index: &'a WallIndex,
        model: &RobotModel,
        within: Option<WithinReach>,
    ) -> Self {
        Self {
            arena,
            index,
            radius_m: model.parameters.body_radius_m,
            within,
        }
    }

    /// Whether a body has room here, and a start pose reaches.
    fn is_free(&self, x_m: f64, y_m: f64) -> bool {
        let (x, y) = (x_m as f32, y_m as f32);
        let room_m = self.radius_m + ROOM_M;
        let place = nalgebra::Point2::new(x_m, y_m);
        let clear = |object: &Movable| object.distance_m(place) >= room_m;
        let touchable = self.index.touchable(x, y);
        self.arena.objects().iter().all(clear)
            && touchable
                .iter()
                .all(|&number| self.index.wall(number).nearest(x, y).2 >= (room_m * room_m) as f32)
            && self
                .within
                .as_ref()
                .is_none_or(|within| within.holds(x_m, y_m))
    }
}

/// Grid points around the first start that the body fits on, ring by ring.
fn grid(room: &Room<'_>, wanted: usize) -> Vec<StartPose> {
    let (arena, radius) = (room.arena, room.radius_m);
    let Some(Pose {
        x_m: x0,
        y_m: y0,
        heading_rad,
    }) = arena.starts().first().copied()
    else {
        return Vec::new();
    };
    let pitch = 2.0 * radius + 2.0 * ROOM_M;
    let last_ring = (arena.width_m().max(arena.height_m()) / pitch) as i64 + 1;
    let mut poses = Vec::with_capacity(wanted);
    for ring in 0..=last_ring {
        for row in -ring..=ring {
            let step = if row.abs() == ring {
                1
            } else {
                (2 * ring).max(1)
            };
            for column in (-ring..=ring).step_by(step as usize) {
                let (x, y) = (x0 + column as f64 * pitch, y0 + row as f64 * pitch);
                let inside = x > radius
                    && y > radius
                    && x < arena.width_m() - radius
                    && y < arena.height_m() - radius;
                if inside && (ring == 0 || room.is_free(x, y)) {
                    poses.push(start_pose(x, y, heading_rad));
                    if poses.len() == wanted {
                        return poses;
                    }
                }
            }
        }
    }
    poses
}

/// Uniformly random poses by rejection, against walls and against those already placed.
fn random(room: &Room<'_>, wanted: usize, seed: u64, site: Site) -> Vec<StartPose> {
    let (arena, radius) = (room.arena, room.radius_m);
    let apart = 2.0 * radius + ROOM_M;
    let (width, height) = (arena.width_m(), arena.height_m());
    let (columns, rows) = ((width / apart) as usize + 1, (height / apart) as usize + 1);
    // The latest body of each cell, and of each body its centre and the one before it in its cell.
    let mut latest = vec![NOBODY; columns * rows];
    let mut bodies: Vec<([f64; 2], u32)> = Vec::with_capacity(wanted);
    let mut stream = Stream::new(stream_key(seed, site, 0, Purpose::Placement));
    let mut poses = Vec::with_capacity(wanted);
    while poses.len() < wanted {
        let mut placed = false;
        for _ in 0..ATTEMPTS {
            let (x, y) = (stream.uniform() * width, stream.uniform() * height);
            let heading = stream.uniform() * std::f64::consts::TAU;
            let (column, row) = ((x / apart) as usize, (y / apart) as usize);
            let inside = x > radius + ROOM_M
                && y > radius + ROOM_M
                && x < width - radius - ROOM_M
                && y < height - radius - ROOM_M;
            let clear = inside
                && room.is_free(x, y)
                && (row.saturating_sub(1)..=(row + 1).min(rows - 1)).all(|r| {
                    (column.saturating_sub(1)..=(column + 1).min(columns - 1)).all(|c| {
                        let mut body = latest[r * columns + c];
                        while let Some(&([ox, oy], before)) = bodies.get(body as usize) {
                            if (ox - x) * (ox - x) + (oy - y) * (oy - y) <= apart * apart {
                                return false;
                            }
                            body = before;
                        }
                        true
                    })
                });
            if clear {
                let latest = &mut latest[row * columns + column];
                let before = std::mem::replace(latest, bodies.len() as u32);
                bodies.push(([x, y], before));
                poses.push(start_pose(x, y, heading));
                placed = true;
                break;
            }
        }
        if !placed {
            break;
        }
    }
    poses
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::world::Ground;

    fn placed(arena: &Arena, placement: Placement, robots: u32) -> Result<usize, FieldError> {
        let model = RobotModel::default();
        let ground = Ground::new(std::sync::Arc::new(arena.clone()), &model);
        place(
            arena,
            &model,
            &ground.index,
            placement,
            robots,
            7,
            Site::Target,
        )
        .map(|poses| poses.len())
    }

    /// The number after `at most`.
    fn most(error: &FieldError) -> u32 {
        let words: Vec<&str> = error.allowed.split(' ').collect();
        assert_eq!(words[..2], ["at", "most"], "{error:?}");
        words[2].parse().unwrap()
    }

    #[test]
    fn a_refusal_tells_the_largest_number_that_fits() {
        // Seven starts in a row, 8 cm apart, but for the sixth, which is too near to the second.
        let starts: Vec<String> = [0.1, 0.18, 0.26, 0.34, 0.42, 0.2, 0.5]
            .map(|x| format!(r#"{{"x_m": {x}, "y_m": 0.3, "heading_rad": 0}}"#))
            .into();
        let arena = Arena::from_json(&format!(
            r#"{{"name": "row", "width_m": 0.6, "height_m": 0.6, "walls_m": [], "starts": [{}]}}"#,
            starts.join(",")
        ))
        .unwrap();
        for (placement, too_many) in [
            (Placement::Start, 7),
            (Placement::Start, 8),
            (Placement::Grid, 1_000),
            (Placement::Random, 1_000),
        ] {
            let error = placed(&arena, placement, too_many).unwrap_err();
            let mut most = most(&error);
            if too_many == 8 {
                // The arena has seven starts; that two of them clash shows next.
                most = self::most(&placed(&arena, placement, most).unwrap_err());
            }
            assert_eq!(placed(&arena, placement, most).unwrap(), most as usize);
            assert!(
                placed(&arena, placement, most + 1).is_err(),
                "{placement:?}"
            );
        }
        assert_eq!(most(&placed(&arena, Placement::Start, 7).unwrap_err()), 5);
    }

    #[test]
    fn where_all_is_within_reach_the_poses_are_those_of_anywhere() {
        let tiling = arenas::Tiling {
            tile: [2, 2],
            doorway_m: Some(0.2),
            ..arenas::Tiling::default()
        };
        let easy = arenas::builtin("easy").unwrap();
        let arenas = [
            easy.tiled(&tiling).unwrap(),
            easy,
            arenas::builtin("maze").unwrap(),
        ];
        let model = RobotModel::default();
        for arena in arenas {
            let ground = Ground::new(std::sync::Arc::new(arena.clone()), &model);
            let placed = |placement, seed| {
                place(
                    &arena,
                    &model,
                    &ground.index,
                    placement,
                    20,
                    seed,
                    Site::Target,
                )
                .unwrap()
            };
            for seed in 0..40 {
                let anywhere = placed(Placement::RandomAnywhere, seed);
                assert_eq!(
                    placed(Placement::Random, seed),
                    anywhere,
                    "{}",
                    arena.name()
                );
            }
            assert_eq!(
                placed(Placement::Grid, 1),
                placed(Placement::GridAnywhere, 1)
            );
        }
    }

    #[test]
    fn robots_stand_only_where_a_start_can_reach_unless_anywhere() {
        let arena = Arena::from_json(
            r#"{"name": "inbox", "width_m": 0.7, "height_m": 0.7, "walls_m": [[0.2, 0.2, 0.5, 0.2],
                [0.5, 0.2, 0.5, 0.5], [0.5, 0.5, 0.2, 0.5], [0.2, 0.5, 0.2, 0.2]],
                "starts": [{"x_m": 0.1, "y_m": 0.1, "heading_rad": 0}]}"#,
        )
        .unwrap();
        let model = RobotModel::default();
        let ground = Ground::new(std::sync::Arc::new(arena.clone()), &model);
        let inside = |placement, seed| {
            let poses = place(
                &arena,
                &model,
                &ground.index,
                placement,
                12,
                seed,
                Site::Target,
            );
            let box_m = 0.2..0.5;
            let poses = poses.unwrap();
            let inside = poses
                .iter()
                .filter(|p| box_m.contains(&p.x_m) && box_m.contains(&p.y_m));
            inside.count()
        };
        let mut anywhere = 0;
        for seed in 0..20 {
            assert_eq!(inside(Placement::Random, seed), 0);
            anywhere += inside(Placement::RandomAnywhere, seed);
        }
        assert!(anywhere > 10, "{anywhere}");
        assert_eq!(inside(Placement::Grid, 1), 0);
        assert!(inside(Placement::GridAnywhere, 1) > 0);
    }
}
