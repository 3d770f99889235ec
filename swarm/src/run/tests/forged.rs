//! Saved state that was changed and sealed again: refused, or a run that goes on.

use sha2::{Digest, Sha256};

use super::{RunSpec, run_of, spec, swarm, valid};
use crate::random::Stream;
use crate::run::Run;
use crate::spec::{Method, RadioLink, Sharing};

/// Magic and digest come before the state.
const HEAD_BYTES: usize = 8 + 32;

/// Snapshots on the way through every phase.
fn snapshots(spec: &RunSpec) -> Vec<Vec<u8>> {
    let mut run = run_of(spec.clone());
    let mut snapshots = Vec::new();
    while run.outcome().is_none() {
        run.advance(77);
        snapshots.push(run.state());
    }
    snapshots
}

fn below(random: &mut Stream, number: usize) -> usize {
    random.below(number as u64) as usize
}

fn forge(state: &mut Vec<u8>, random: &mut Stream) {
    for _ in 0..=below(random, 4) {
        let at = HEAD_BYTES + below(random, state.len() - HEAD_BYTES);
        match below(random, 5) {
            0 => state[at] ^= 1 << below(random, 8),
            1 => state[at] = 0,
            2 => state[at] = 255,
            3 => drop(state.remove(at)),
            _ => state[at] = below(random, 256) as u8,
        }
        if state.len() <= HEAD_BYTES {
            return;
        }
    }
    let (head, rest) = state.split_at_mut(HEAD_BYTES);
    head[8..].copy_from_slice(&Sha256::digest(rest));
}

#[test]
fn forged_state_is_refused_or_goes_on() {
    let short = |method| RunSpec {
        epochs: 2,
        steps_per_epoch: 100,
        ..spec(method)
    };
    let with = |sharing| RunSpec {
        sharing,
        ..swarm(Method::EvIterC, 2)
    };
    let radio = RadioLink {
        range_m: None,
        bytes_per_step: 64,
    };
    let specs = [
        short(Method::Im),
        short(Method::EvIterC),
        short(Method::CuriosityA),
        short(Method::Levy),
        with(Sharing::Arena),
        with(Sharing::Radio(radio)),
    ];
    let mut random = Stream::new(3);
    let (mut refused, mut gone_on) = (0, 0);
    for spec in &specs {
        for snapshot in snapshots(spec) {
            for _ in 0..150 {
                let mut forged = snapshot.clone();
                forge(&mut forged, &mut random);
                match Run::restore(valid(spec.clone()), &forged) {
                    Err(_) => refused += 1,
                    Ok(mut run) => {
                        run.advance(150);
                        run.snapshot();
                        gone_on += 1;
                    }
                }
            }
        }
    }
    assert!(refused > 500 && gone_on > 100, "{refused}, {gone_on}");
}
