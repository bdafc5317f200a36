//! Work against precision of every method on every scene: `cargo bench --bench work_precision`.

mod scenes;

struct Names;

impl scenes::Visitor for Names {
    fn visit<S: bristle::ode::System<f64, N> + Clone, const N: usize>(
        &mut self,
        scene: &scenes::Scene<S, N>,
    ) {
        println!("{} {} {}", scene.name, scene.model, scene.end);
    }
}

fn main() {
    let _ = scenes::each(&mut Names);
}
