//! Radau nodes and what collocation at them needs, worked out by the compiler for any number of
//! nodes.
//!
//! On the unit step the S nodes c₁ < … < c_S = 1 are the zeros of P_S − P_{S−1}, the Legendre
//! polynomials moved to [0, 1]. With weights b their quadrature is exact up to degree 2S − 2. A
//! polynomial of degree S with the value 0 at the start and y_j at the nodes has the slopes
//! Σ D_ij y_j there: D is the inverse of the Runge–Kutta matrix of the method Radau IIA.
//!
//! Source: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", section IV.5.

/// Largest number of nodes.
pub(super) const MOST_NODES: usize = 8;

/// Everything that depends on the number of nodes alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nodes<const S: usize> {
    /// c, from just above 0 to exactly 1.
    pub(super) places: [f64; S],
    /// b, all positive, with the sum 1.
    pub(super) weights: [f64; S],
    /// D, row by row.
    pub(super) slopes: [[f64; S]; S],
    /// The power k + 1 of θ in the polynomial that is 1 at one of the points 0, c₁, …, c_S and 0 at
    /// the others: row k, for the point 0 …
    pub(super) powers_of_start: [f64; S],
    /// … and for each node. The power 0 is 1 for the point 0 and 0 for each node.
    pub(super) powers: [[f64; S]; S],
    /// The last four Legendre coefficients, of degree S − 3 to S, of that polynomial: from the
    /// point 0 …
    pub(super) tail_of_start: [f64; 4],
    /// … and from each node. For S = 2 the first is zero.
    pub(super) tail: [[f64; S]; 4],
}

impl<const S: usize> Nodes<S> {
    /// For 2 to 8 nodes.
    pub(super) const OF: Self = Self::new();

    const fn new() -> Self {
        assert!(S >= 2 && S <= MOST_NODES, "between 2 and 8 nodes");
        let c = places::<S>();
        let mut nodes = Self {
            places: c,
            weights: [0.0; S],
            slopes: [[0.0; S]; S],
            powers_of_start: [0.0; S],
            powers: [[0.0; S]; S],
            tail_of_start: [0.0; 4],
            tail: [[0.0; S]; 4],
        };
        let order = S as f64;
        let mut i = 0;
        while i < S {
            // With q = ∏(c − c_k) over the point 0 and the other nodes, D_ij = q_i/(q_j (c_i −
            // c_j)).
            let (q_i, poles) = product(&c, i);
            let mut j = 0;
            while j < S {
                let (q_j, _) = product(&c, j);
                nodes.slopes[i][j] = if i == j { poles } else { q_i / (q_j * (c[i] - c[j])) };
                j += 1;
            }
            // b_i = (1 + x)/(S P_{S−1}(x))² with x = 1 − 2c_i, from the mirrored nodes.
            let (before, _) = legendre::<S>(c[i]);
            nodes.weights[i] = c[i] / (order * order * before * before);
            let powers = expanded(&c, i, q_i);
            let mut k = 0;
            while k < S {
                nodes.powers[k][i] = powers[k];
                // All of them together are 1 everywhere.
                nodes.powers_of_start[k] -= powers[k];
                k += 1;
            }
            i += 1;
        }
        let mut row = 0;
        while row < 4 {
            if S + row >= 3 {
                let degree = S + row - 3;
                // The power 0 has the coefficient 1 of degree 0, and no other.
                if degree == 0 {
                    nodes.tail_of_start[row] = 1.0;
                }
                let mut k = 0;
                while k < S {
                    let share = share_of(degree, k + 1);
                    nodes.tail_of_start[row] += share * nodes.powers_of_start[k];
                    let mut i = 0;
                    while i < S {
                        nodes.tail[row][i] += share * nodes.powers[k][i];
                        i += 1;
                    }
                    k += 1;
                }
            }
            row += 1;
        }
        nodes
    }
}

/// c_i ∏(c_i − c_k), and 1/c_i + Σ 1/(c_i − c_k), over the other nodes.
const fn product<const S: usize>(c: &[f64; S], i: usize) -> (f64, f64) {
    let (mut product, mut poles) = (c[i], 1.0 / c[i]);
    let mut k = 0;
    while k < S {
        if k != i {
            product *= c[i] - c[k];
            poles += 1.0 / (c[i] - c[k]);
        }
        k += 1;
    }
    (product, poles)
}

/// The powers 1 to S of θ ∏(θ − c_k)/q_i over the other nodes.
const fn expanded<const S: usize>(c: &[f64; S], i: usize, q_i: f64) -> [f64; S] {
    let mut powers = [0.0; S];
    powers[0] = 1.0 / q_i;
    let mut k = 0;
    while k < S {
        if k != i {
            let mut power = S - 1;
            while power > 0 {
                powers[power] = powers[power - 1] - c[k] * powers[power];
                power -= 1;
            }
            powers[0] *= -c[k];
        }
        k += 1;
    }
    powers
}

/// The Legendre coefficient of a degree in a power of θ: (2k + 1) m!²/((m − k)! (m + k + 1)!).
const fn share_of(degree: usize, power: usize) -> f64 {
    if power < degree {
        return 0.0;
    }
    let mut share = (2 * degree + 1) as f64 / (power + 1) as f64;
    let mut k = 0;
    while k < degree {
        share *= (power - k) as f64 / (power + k + 2) as f64;
        k += 1;
    }
    share
}

/// P_{S−1} and P_S at a place on [0, 1].
const fn legendre<const S: usize>(place: f64) -> (f64, f64) {
    let x = 2.0 * place - 1.0;
    let (mut before, mut value) = (1.0, x);
    let mut n = 1;
    while n < S {
        let next = ((2 * n + 1) as f64 * x * value - n as f64 * before) / (n + 1) as f64;
        before = value;
        value = next;
        n += 1;
    }
    (before, value)
}

/// The zeros of P_S − P_{S−1}, by bisection: no two are closer than 1/S².
const fn places<const S: usize>() -> [f64; S] {
    let mut places = [1.0; S];
    let intervals = 2 * S * S;
    let (mut found, mut interval) = (0, 0);
    // The last zero, 1, lies at the end of the last interval and is known.
    while interval < intervals && found < S - 1 {
        let mut a = interval as f64 / intervals as f64;
        let mut b = (interval + 1) as f64 / intervals as f64;
        let rising = difference::<S>(b) > difference::<S>(a);
        if (difference::<S>(a) > 0.0) != (difference::<S>(b) > 0.0) {
            let mut halving = 0;
            while halving < 60 {
                let middle = 0.5 * (a + b);
                if (difference::<S>(middle) > 0.0) == rising {
                    b = middle;
                } else {
                    a = middle;
                }
                halving += 1;
            }
            places[found] = 0.5 * (a + b);
            found += 1;
        }
        interval += 1;
    }
    places
}

const fn difference<const S: usize>(place: f64) -> f64 {
    let (before, value) = legendre::<S>(place);
    value - before
}

#[cfg(test)]
mod tests {
    use super::Nodes;

    fn power(x: f64, n: usize) -> f64 {
        (0..n).fold(1.0, |product, _| product * x)
    }

    fn check<const S: usize>() {
        let table = &Nodes::<S>::OF;
        let sum = |f: &dyn Fn(usize) -> f64| (0..S).map(f).sum::<f64>();
        assert_eq!(table.places[S - 1], 1.0);
        assert!(table.places.windows(2).all(|pair| 0.0 < pair[0] && pair[0] < pair[1]), "{S}");
        assert!(table.weights.iter().all(|&weight| weight > 0.0), "{S}");
        for n in 0..2 * S - 1 {
            // ∫θⁿ = 1/(n + 1), but for the roundings of S terms.
            let found = sum(&|i| table.weights[i] * power(table.places[i], n));
            assert!((found * (n + 1) as f64 - 1.0).abs() < 1e-14, "{S} {n}: {found}");
        }
        for n in 1..=S {
            for i in 0..S {
                // Dᵢⱼ cⱼⁿ = n cᵢⁿ⁻¹; the sums lose what their largest terms, about S², round.
                let found = sum(&|j| table.slopes[i][j] * power(table.places[j], n));
                let wanted = n as f64 * power(table.places[i], n - 1);
                assert!(
                    (found - wanted).abs() < 1e-13 * (S * S) as f64,
                    "{S} {n} {i}: {found} {wanted}"
                );
            }
            for k in 1..=S {
                // θⁿ in powers of θ is itself.
                let found = sum(&|j| table.powers[k - 1][j] * power(table.places[j], n));
                let wanted = f64::from(u8::from(k == n));
                assert!((found - wanted).abs() < 1e-10, "{S} {n} {k}: {found}");
            }
        }
        // The Legendre polynomials of the last degrees, moved to [0, 1].
        for degree in S.saturating_sub(3)..=S {
            let legendre = |place: f64| {
                let x = 2.0 * place - 1.0;
                let (mut before, mut value) = (0.0, 1.0);
                for n in 0..degree {
                    let next =
                        ((2 * n + 1) as f64 * x * value - n as f64 * before) / (n + 1) as f64;
                    (before, value) = (value, next);
                }
                value
            };
            for row in (0..4).filter(|row| S + row >= 3) {
                let at_nodes = sum(&|j| table.tail[row][j] * legendre(table.places[j]));
                let found = at_nodes + table.tail_of_start[row] * legendre(0.0);
                let wanted = f64::from(u8::from(S + row - 3 == degree));
                assert!((found - wanted).abs() < 1e-10, "{S} {degree} {row}: {found}");
            }
        }
    }

    #[test]
    fn quadrature_slopes_powers_and_tails_are_exact_up_to_their_degrees() {
        check::<2>();
        check::<3>();
        check::<4>();
        check::<5>();
        check::<6>();
        check::<7>();
        check::<8>();
    }

    #[test]
    fn the_nodes_are_those_of_the_literature() {
        // Hairer & Wanner, tables IV.5.5 and IV.5.6.
        let root = 2.449_489_742_783_178; // √6
        assert!((Nodes::<2>::OF.places[0] - 1.0 / 3.0).abs() < 2e-16);
        assert!((Nodes::<3>::OF.places[0] - (4.0 - root) / 10.0).abs() < 2e-16);
        assert!((Nodes::<3>::OF.places[1] - (4.0 + root) / 10.0).abs() < 2e-16);
    }
}
