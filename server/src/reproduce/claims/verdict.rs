//! From p to verdicts: Holm over all tests, then the rule for a test and for a claim.

use super::claim::{Claim, Level, Test, Verdict};
use crate::statistics::holm;

/// Level of significance after correction.
pub const ALPHA: f64 = 0.05;

/// Corrects every p of the table, one family for the claims' direction and one for the opposite,
/// and decides. Tests without a p keep the verdict they came with. Returns the size of a family.
pub fn decide(claims: &mut [Claim]) -> usize {
    let mut tests: Vec<&mut Test> = claims
        .iter_mut()
        .flat_map(|claim| &mut claim.tests)
        .filter(|test| test.p.is_some())
        .collect();
    let number = tests.len();
    let family = |p: fn(&Test) -> Option<f64>, tests: &[&mut Test]| {
        holm(
            &tests
                .iter()
                .map(|test| p(test).unwrap_or(1.0))
                .collect::<Vec<f64>>(),
        )
    };
    let forward = family(|test| test.p, &tests);
    let opposite = family(|test| test.p_opposite, &tests);
    for ((test, p), p_opposite) in tests.iter_mut().zip(forward).zip(opposite) {
        test.p_holm = Some(p);
        test.p_opposite_holm = Some(p_opposite);
        test.verdict = of_test(p, p_opposite);
    }
    for claim in claims {
        let at = |level| {
            let tests = claim.tests.iter();
            of_claim(tests.filter(move |test| test.level == level))
        };
        let [verdict, verdict_p10, verdict_over_time] = Level::ALL.map(at);
        claim.verdict = verdict;
        claim.verdict_p10 = verdict_p10;
        claim.verdict_over_time = verdict_over_time;
    }
    number
}

fn of_test(p: f64, p_opposite: f64) -> Verdict {
    // With equivalence both can be significant: a difference that is certain but small.
    if p < ALPHA {
        Verdict::Reproduced
    } else if p_opposite < ALPHA {
        Verdict::Contradicted
    } else {
        Verdict::Inconclusive
    }
}

fn of_claim<'a>(tests: impl Iterator<Item = &'a Test> + Clone) -> Verdict {
    let any = |verdict| tests.clone().any(|test| test.verdict == verdict);
    if tests.clone().next().is_none() {
        Verdict::NotTested
    } else if any(Verdict::Contradicted) {
        Verdict::Contradicted
    } else if any(Verdict::Inconclusive) {
        Verdict::Inconclusive
    } else {
        Verdict::Reproduced
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(p: f64, p_opposite: f64) -> Test {
        Test {
            arena: "maze".to_owned(),
            hypothesis: String::new(),
            level: Level::P1,
            test: "",
            n: vec![15, 15],
            statistic: 0.0,
            p: Some(p),
            p_holm: None,
            p_opposite_holm: None,
            p_opposite: Some(p_opposite),
            effect_size: "",
            effect: 0.5,
            median_difference: None,
            unit: None,
            verdict: Verdict::NotTested,
        }
    }

    fn claim(tests: Vec<Test>) -> Claim {
        Claim {
            claim: 1,
            text: "",
            how: String::new(),
            verdict: Verdict::NotTested,
            verdict_p10: Verdict::NotTested,
            verdict_over_time: Verdict::NotTested,
            reason: None,
            tests,
        }
    }

    fn verdicts(claims: &[Claim]) -> Vec<Verdict> {
        claims.iter().map(|claim| claim.verdict).collect()
    }

    #[test]
    fn the_correction_is_over_all_claims() {
        // 0.02 alone is significant, as one of three it is not.
        let mut alone = [claim(vec![test(0.02, 0.98)])];
        assert_eq!(decide(&mut alone), 1);
        assert_eq!(verdicts(&alone), [Verdict::Reproduced]);
        let mut three = [
            claim(vec![test(0.02, 0.98)]),
            claim(vec![test(0.3, 0.7), test(0.5, 0.5)]),
        ];
        assert_eq!(decide(&mut three), 3);
        assert_eq!(verdicts(&three), [Verdict::Inconclusive; 2]);
        assert_eq!(three[0].tests[0].p_holm, Some(0.06));
    }

    #[test]
    fn a_claim_stands_with_all_its_tests_and_falls_with_one() {
        let good = || test(1e-6, 1.0 - 1e-6);
        let bad = || test(1.0 - 1e-6, 1e-6);
        let open = || test(0.4, 0.6);
        let mut claims = [
            claim(vec![good(), good()]),
            claim(vec![good(), open()]),
            claim(vec![good(), bad(), open()]),
            claim(Vec::new()),
        ];
        decide(&mut claims);
        let expected = [
            Verdict::Reproduced,
            Verdict::Inconclusive,
            Verdict::Contradicted,
            Verdict::NotTested,
        ];
        assert_eq!(verdicts(&claims), expected);
    }

    #[test]
    fn every_level_has_a_verdict_of_its_own() {
        let at = |level, p: f64| Test {
            level,
            ..test(p, 1.0 - p)
        };
        let good = 1e-6;
        let mut claims = [
            claim(vec![
                at(Level::P1, 0.4),
                at(Level::P10, good),
                at(Level::OverTime, 1.0 - good),
            ]),
            claim(vec![at(Level::P1, good)]),
        ];
        assert_eq!(decide(&mut claims), 4);
        let verdicts = claims
            .each_ref()
            .map(|c| [c.verdict, c.verdict_p10, c.verdict_over_time]);
        let (yes, open) = (Verdict::Reproduced, Verdict::Inconclusive);
        let untested = Verdict::NotTested;
        assert_eq!(
            verdicts,
            [
                [open, yes, Verdict::Contradicted],
                [yes, untested, untested]
            ]
        );
    }

    #[test]
    fn a_bare_count_keeps_its_verdict_and_is_in_no_family() {
        let mut count = test(0.0, 0.0);
        (count.p, count.p_opposite, count.verdict) = (None, None, Verdict::Contradicted);
        let mut claims = [claim(vec![count, test(0.03, 0.97)])];
        assert_eq!(decide(&mut claims), 1);
        assert_eq!(claims[0].tests[0].p_holm, None);
        assert_eq!(claims[0].tests[1].verdict, Verdict::Reproduced);
        assert_eq!(verdicts(&claims), [Verdict::Contradicted]);
    }
}
