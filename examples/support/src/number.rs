//! Numbers as text that reads back to the same bits.

/// The shorter of the plain and the exponent form of `value`. Both round-trip: Rust prints the fewest digits that do.
pub(crate) fn shortest(value: f64) -> String {
    let (plain, exponent) = (format!("{value}"), format!("{value:e}"));
    if exponent.len() < plain.len() { exponent } else { plain }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shorter_form_is_chosen() {
        assert_eq!(shortest(0.1), "0.1");
        assert_eq!(shortest(60.0), "60");
        assert_eq!(shortest(1e-9), "1e-9");
        assert_eq!(shortest(1e5), "1e5");
        assert_eq!(shortest(f64::NAN), "NaN");
    }

    #[test]
    fn every_number_reads_back_to_the_same_bits() {
        for value in
            [0.1 + 0.2, f64::MIN_POSITIVE, 5e-324, f64::MAX, -0.0, 1.0 / 3.0, f64::NEG_INFINITY]
        {
            assert_eq!(shortest(value).parse::<f64>().map(f64::to_bits), Ok(value.to_bits()));
        }
    }
}
