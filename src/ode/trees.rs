//! Rooted trees, and what the order conditions make of them: for the tests of the tableaux.
//!
//! Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd
//! edition (Springer, 1993), section II.2; for Rosenbrock methods E. Hairer, G. Wanner, part II,
//! section IV.7.

extern crate std;
use std::vec;
use std::vec::Vec;

/// A rooted tree as the list of its root's subtrees.
#[derive(Clone, Debug)]
pub(super) struct Tree(Vec<Tree>);

impl Tree {
    /// The number of nodes.
    pub(super) fn order(&self) -> usize {
        1 + self.0.iter().map(Tree::order).sum::<usize>()
    }

    /// γ, the density: 1/γ is what the weighted sum over the tree must be.
    pub(super) fn density(&self) -> f64 {
        self.0.iter().map(Tree::density).product::<f64>() * self.order() as f64
    }
}

/// All rooted trees of up to so many nodes.
pub(super) fn trees(most: usize) -> Vec<Tree> {
    let mut all = vec![Tree(vec![])];
    for order in 2..=most {
        let known = all.clone();
        extend(&known, 0, order - 1, &mut Vec::new(), &mut all);
    }
    all
}

/// Every set of known trees with so many nodes left, in non-decreasing position, under a root.
fn extend(known: &[Tree], from: usize, left: usize, picked: &mut Vec<Tree>, all: &mut Vec<Tree>) {
    if left == 0 {
        all.push(Tree(picked.clone()));
        return;
    }
    for i in from..known.len() {
        if known[i].order() <= left {
            picked.push(known[i].clone());
            extend(known, i, left - known[i].order(), picked, all);
            picked.pop();
        }
    }
}

/// An explicit Runge–Kutta method: the weights of the earlier stages in each.
pub(super) struct RungeKutta {
    pub(super) a: Vec<Vec<f64>>,
}

impl RungeKutta {
    /// The elementary weight of a tree at each stage.
    fn stages(&self, tree: &Tree) -> Vec<f64> {
        let mut product = vec![1.0; self.a.len()];
        for child in &tree.0 {
            let below = self.stages(child);
            for (factor, row) in product.iter_mut().zip(&self.a) {
                *factor *= row.iter().zip(&below).map(|(a, b)| a * b).sum::<f64>();
            }
        }
        product
    }

    pub(super) fn weighted(&self, tree: &Tree, weights: &[f64]) -> f64 {
        self.stages(tree).iter().zip(weights).map(|(s, w)| s * w).sum()
    }

    /// The sum over a tree within the step, for the nested form of `DenseOutput`: weights of the
    /// solution, the stage at the end of the step, weights of the terms from the fourth on.
    pub(super) fn extended(
        &self,
        tree: &Tree,
        theta: f64,
        solution: &[f64],
        last: usize,
        inner: &[&[f64]],
    ) -> f64 {
        let phi = self.stages(tree);
        let chord = self.weighted(tree, solution);
        let from_start = phi[0] - chord;
        let mut terms = vec![chord, from_start, chord - phi[last] - from_start];
        terms.extend(inner.iter().map(|weights| self.weighted(tree, weights)));
        nested(&terms, theta)
    }
}

/// A Rosenbrock method: αᵢⱼ and βᵢⱼ = αᵢⱼ + γᵢⱼ, from the form in which its stages are solved.
pub(super) struct Rosenbrock {
    pub(super) alpha: Vec<Vec<f64>>,
    pub(super) beta: Vec<Vec<f64>>,
    gammas: Vec<Vec<f64>>,
}

impl Rosenbrock {
    /// Γ⁻¹ = I/γ − C and α = A Γ.
    pub(super) fn new(gamma: f64, a: &[Vec<f64>], c: &[&[f64]]) -> Self {
        let s = c.len();
        // Forward substitution: (I/γ − C) Γ = I.
        let mut gammas = vec![vec![0.0; s]; s];
        for i in 0..s {
            let entry = |j: usize| {
                let unit = f64::from(u8::from(i == j));
                gamma * (unit + (j..i).map(|k| c[i][k] * gammas[k][j]).sum::<f64>())
            };
            let row: Vec<f64> = (0..s).map(|j| if j <= i { entry(j) } else { 0.0 }).collect();
            gammas[i] = row;
        }
        let times = |row: &Vec<f64>| -> Vec<f64> {
            (0..s).map(|j| row.iter().zip(&gammas).map(|(a, row)| a * row[j]).sum()).collect()
        };
        let alpha: Vec<Vec<f64>> = a.iter().map(times).collect();
        let add = |(x, y): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
            x.iter().zip(y).map(|(x, y)| x + y).collect()
        };
        let beta = alpha.iter().zip(&gammas).map(add).collect();
        Self { alpha, beta, gammas }
    }

    /// Weights of the stages kᵢ from those of the Uᵢ.
    pub(super) fn weights(&self, of_u: &[f64]) -> Vec<f64> {
        let column = |j: usize| of_u.iter().zip(&self.gammas).map(|(m, row)| m * row[j]).sum();
        (0..self.alpha.len()).map(column).collect()
    }

    /// Σⱼ γᵢⱼ, which weighs ∂f/∂t.
    pub(super) fn time_weight(&self, stage: usize) -> f64 {
        self.gammas[stage].iter().sum()
    }

    /// The elementary weight of a tree at each stage: β where a node has one child, α where it has
    /// more.
    fn stages(&self, tree: &Tree) -> Vec<f64> {
        let rows = if tree.0.len() == 1 { &self.beta } else { &self.alpha };
        let mut product = vec![1.0; rows.len()];
        for child in &tree.0 {
            let below = self.stages(child);
            for (factor, row) in product.iter_mut().zip(rows) {
                *factor *= row.iter().zip(&below).map(|(a, b)| a * b).sum::<f64>();
            }
        }
        product
    }

    /// The sum over a tree with weights of the Uᵢ.
    pub(super) fn weighted(&self, tree: &Tree, of_u: &[f64]) -> f64 {
        let weights = self.weights(of_u);
        self.stages(tree).iter().zip(weights).map(|(s, w)| s * w).sum()
    }

    /// The sum over a tree within the step, for the nested form: weights of the Uᵢ in each term.
    pub(super) fn extended(&self, tree: &Tree, theta: f64, terms: &[&[f64]]) -> f64 {
        let terms: Vec<f64> = terms.iter().map(|weights| self.weighted(tree, weights)).collect();
        nested(&terms, theta)
    }
}

/// θ(q₀ + θ̄(q₁ + θ(q₂ + …))).
fn nested(terms: &[f64], theta: f64) -> f64 {
    terms.iter().enumerate().rev().fold(0.0, |value, (index, term)| {
        (term + value) * if index % 2 == 0 { theta } else { 1.0 - theta }
    })
}

#[test]
fn there_are_as_many_trees_as_order_conditions() {
    let all = trees(8);
    let count = |order| all.iter().filter(|tree| tree.order() == order).count();
    assert_eq!([1, 2, 3, 4, 5, 6, 7, 8].map(count), [1, 1, 2, 4, 9, 20, 48, 115]);
}
