//! How CSV has numbers that need not be whole.

use std::fmt::{self, Debug, Display, Formatter};

/// In the shortest digits that read back equal, always with a point or an exponent: a column that
/// happens to hold whole numbers alone is read as what it is in every other file. What is missing or
/// not finite is an empty cell.
#[derive(Clone, Copy)]
pub struct Decimal<T>(pub T);

impl Display for Decimal<f64> {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        shown(self.0, self.0.is_finite(), out)
    }
}

impl Display for Decimal<f32> {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        shown(self.0, self.0.is_finite(), out)
    }
}

impl Display for Decimal<Option<f64>> {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |number| Decimal(number).fmt(out))
    }
}

fn shown(number: impl Debug, is_finite: bool, out: &mut Formatter<'_>) -> fmt::Result {
    match is_finite {
        true => write!(out, "{number:?}"),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_decimals_too() {
        for (number, text) in [
            (0.0, "0.0"),
            (-0.0, "-0.0"),
            (1.0, "1.0"),
            (0.1, "0.1"),
            (1e21, "1e21"),
            (1e-7, "1e-7"),
            (f64::NAN, ""),
            (f64::INFINITY, ""),
        ] {
            assert_eq!(Decimal(number).to_string(), text);
            assert_eq!(Decimal(Some(number)).to_string(), text);
        }
        assert_eq!(Decimal(None::<f64>).to_string(), "");
        assert_eq!(Decimal(0.1_f32).to_string(), "0.1");
        assert_eq!(Decimal(3.0_f32).to_string(), "3.0");
    }
}
