//! What a watcher saw, as it is told: figures, and one sentence.

use api::explanation::{ActionScore, Behaviour, Explanation, StayedFor, Tried};

use super::kind::Kind;
use super::stretch::Pair;
use super::watch::{Told, Watcher};

/// Shares of counted robot-steps from which on a run behaves oddly.
const ODD: f64 = 0.25;
/// States and actions that are listed of a stretch.
const LISTED: usize = 5;

/// What is known of the run beside what was watched.
pub struct About {
    /// Robots of the run.
    pub robots: u32,
    /// Steps of an epoch.
    pub steps_per_epoch: u32,
    /// Epochs of an arena before visits count.
    pub first_counted_epoch: u64,
    /// Steps of robots that were simulated for this.
    pub robot_steps: u64,
}

/// What a watcher saw.
pub fn explanation(watcher: &Watcher, about: &About) -> Explanation {
    let steps = watcher.steps.max(1) as f64;
    let behaviours: Vec<Behaviour> = Kind::ALL
        .into_iter()
        .enumerate()
        .filter(|(place, _)| watcher.in_kind[*place] > 0)
        .map(|(place, kind)| Behaviour {
            name: kind.name().to_owned(),
            share: watcher.in_kind[place] as f64 / steps,
            epochs: watcher.epochs[place].len() as u64,
        })
        .collect();
    let told = |told: &Told| stayed(told, about);
    let [still, near] = &watcher.longest;
    Explanation {
        sentence: sentence(watcher, about, &behaviours),
        is_odd: is_odd(&behaviours),
        behaviours,
        standing: still.iter().map(told).collect(),
        confined: near.iter().map(told).collect(),
        epochs: watcher.epochs_seen,
        robots_watched: watcher
            .steps
            .checked_div(counted_steps(watcher, about))
            .unwrap_or(0),
        robots: about.robots,
        simulated_robot_steps: about.robot_steps,
    }
}

fn counted_steps(watcher: &Watcher, about: &About) -> u64 {
    watcher.epochs_seen * u64::from(about.steps_per_epoch)
}

fn is_odd(behaviours: &[Behaviour]) -> bool {
    behaviours
        .iter()
        .map(|behaviour| behaviour.share)
        .sum::<f64>()
        >= ODD
}

fn stayed(told: &Told, about: &About) -> StayedFor {
    let Told {
        robot,
        kind,
        stretch,
    } = told;
    let steps = u64::from(about.steps_per_epoch);
    let epoch = stretch.from_step / steps;
    let (states, actions) = (by(&stretch.pairs, |p| p.0), by(&stretch.pairs, |p| p.1));
    let scores = stretch.scores.as_ref();
    StayedFor {
        robot: *robot,
        behaviour: kind.name().to_owned(),
        x_m: round(stretch.at_m[0]),
        y_m: round(stretch.at_m[1]),
        from_step: stretch.from_step,
        epoch,
        counted_epoch: epoch.saturating_sub(about.first_counted_epoch) + 1,
        epoch_step: (stretch.from_step % steps) as u32,
        steps: stretch.steps,
        driven_m: stretch.driven_m(),
        turns: stretch.turns(),
        states: tried(&states),
        actions: tried(&actions),
        action_changes: stretch.switches,
        scored_state: scores.map(|(state, _)| *state),
        scores: scores.map_or_else(Vec::new, |(_, scores)| {
            let scores = scores.iter().enumerate();
            scores
                .map(|(action, (score, tries))| ActionScore {
                    action: action as u32,
                    score: f64::from(*score),
                    tries: *tries,
                })
                .collect()
        }),
    }
}

fn round(metres: f32) -> f64 {
    (f64::from(metres) * 1e4).round() / 1e4
}

/// How often each, the most frequent first.
fn by(pairs: &[(Pair, u64)], of: impl Fn(&Pair) -> u32) -> Vec<(u32, u64)> {
    let mut counts: Vec<(u32, u64)> = Vec::new();
    for (pair, count) in pairs {
        let number = of(pair);
        match counts.iter_mut().find(|(known, _)| *known == number) {
            Some((_, all)) => *all += count,
            None => counts.push((number, *count)),
        }
    }
    counts.sort_by_key(|(number, count)| (std::cmp::Reverse(*count), *number));
    counts
}

fn tried(counts: &[(u32, u64)]) -> Vec<Tried> {
    let listed = counts.iter().take(LISTED);
    listed
        .map(|&(number, steps)| Tried { number, steps })
        .collect()
}

/// One sentence: what robots did most of what is odd, where, in which state and by which scores.
fn sentence(watcher: &Watcher, about: &About, behaviours: &[Behaviour]) -> String {
    if watcher.steps == 0 {
        return "No epoch was counted, so there is nothing to tell.".to_owned();
    }
    let worst = behaviours
        .iter()
        .max_by(|a, b| a.share.total_cmp(&b.share))
        .filter(|_| is_odd(behaviours));
    let Some(worst) = worst else {
        return format!(
            "Nothing odd: robots stayed where they were for {} of their steps.",
            percent(behaviours.iter().map(|behaviour| behaviour.share).sum())
        );
    };
    let all = watcher.longest.iter().flatten();
    let longest = all
        .filter(|told| told.kind.name() == worst.name)
        .max_by_key(|told| told.stretch.steps);
    let Some(told) = longest else {
        return format!(
            "Robots were {} for {} of their steps.",
            worst.name,
            percent(worst.share)
        );
    };
    let stay = stayed(told, about);
    let place = if watcher.longest[0]
        .iter()
        .any(|other| std::ptr::eq(other, told))
    {
        "within 1 mm"
    } else {
        "within 5 cm"
    };
    let robots = match about.robots {
        1 => "The robot was".to_owned(),
        robots => format!("The {robots} robots were"),
    };
    let mut text = format!(
        "{robots} {} for {} of all counted steps, in {} of {} epochs; the longest time, robot {} \
         stayed {place} of ({:.3}, {:.3}) m for {} steps from step {} of counted epoch {} on, {}",
        worst.name,
        percent(worst.share),
        worst.epochs,
        watcher.epochs_seen,
        stay.robot,
        stay.x_m,
        stay.y_m,
        stay.steps,
        stay.epoch_step,
        stay.counted_epoch,
        told.kind.doing(),
    );
    text.push_str(&decided(&stay));
    text.push('.');
    text
}

/// In which state, by which actions, and why those.
fn decided(stay: &StayedFor) -> String {
    let Some(state) = stay.states.first() else {
        return String::new();
    };
    let share = |tried: &Tried| percent(tried.steps as f64 / stay.steps.max(1) as f64);
    let mut text = format!(" in state {} ({} of the steps)", state.number, share(state));
    match stay.actions.as_slice() {
        [] => {}
        [only] => text += &format!(", always by action {}", only.number),
        [first, second, ..] if stay.action_changes * 5 > stay.steps => {
            let both = format!("{} and {}", first.number, second.number);
            text += &format!(
                ", changing the action {} times, mostly between {both}",
                stay.action_changes
            );
        }
        [first, ..] => text += &format!(", by action {} ({})", first.number, share(first)),
    }
    let best = stay
        .scores
        .iter()
        .max_by(|a, b| a.score.total_cmp(&b.score));
    let chosen = stay.actions.first().and_then(|chosen| {
        let scores = &stay.scores;
        scores.iter().find(|scored| scored.action == chosen.number)
    });
    if let (Some(best), Some(chosen), Some(scored)) = (best, chosen, stay.scored_state)
        && scored == state.number
    {
        let tied = stay.scores.iter().filter(|other| other.score == best.score);
        let tied = tied.count();
        text += &match (chosen.score == best.score, tied) {
            (true, 1) => format!(
                ", whose score {:.4} is the highest of {}",
                chosen.score,
                stay.scores.len()
            ),
            (true, tied) => format!(
                ", whose score {:.4} is the highest of {}, shared by {tied}",
                chosen.score,
                stay.scores.len()
            ),
            (false, _) => format!(
                ", whose score {:.4} is below the highest, {:.4} of action {}",
                chosen.score, best.score, best.action
            ),
        };
    }
    text
}

fn percent(share: f64) -> String {
    // The sum of no shares is -0.
    format!("{:.0} %", 100.0 * share + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_nothing_has_no_sign() {
        assert_eq!(percent(std::iter::empty::<f64>().sum()), "0 %");
        assert_eq!(percent(0.254), "25 %");
    }
}
