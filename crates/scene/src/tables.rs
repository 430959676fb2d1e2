//! Settings and materials as tables of a scene file: for programs that change them and want to keep what they have.

use crate::root::{INTEGRATORS, MIXES, solver_word};
use crate::visual::{self, Color};
use rockfall::{Integrator, Material, Mix, Settings};

/// The table `[world]` of a scene with these settings. Threads, lanes, and switches that a scene does not have, are not in it.
pub fn world_table(settings: &Settings, frames: u64, seed: u64) -> String {
    // Taken apart, so that none is forgotten.
    let &Settings {
        gravity,
        rate,
        substeps,
        solver,
        integrator,
        contact_hertz,
        contact_damping,
        push_speed,
        restitution_threshold,
        bounce_sweeps,
        sleeping,
        sleep_speed,
        sleep_time,
        continuous,
        reuse: _,
        tiles_from: _,
        threads: _,
        lanes: _,
    } = settings;
    let [x, y, z] = gravity.to_array();
    let integrator = match integrator {
        Integrator::SecondOrder => INTEGRATORS[0],
        Integrator::SemiImplicit => INTEGRATORS[1],
    };
    // With `?` every number is a float of TOML, however large or small.
    format!(
        "[world]\ngravity = [{x:?}, {y:?}, {z:?}]\nrate = {rate:?}\nsubsteps = {substeps}\nsolver = \"{}\"\nintegrator = \"{integrator}\"\n\
         frames = {frames}\nseed = {seed}\ncontact_hertz = {contact_hertz:?}\ncontact_damping = {contact_damping:?}\npush_speed = {push_speed:?}\n\
         restitution_threshold = {restitution_threshold:?}\nbounce_sweeps = {bounce_sweeps}\nsleeping = {sleeping}\nsleep_speed = {sleep_speed:?}\n\
         sleep_time = {sleep_time:?}\ncontinuous = {continuous}\n",
        solver_word(solver)
    )
}

/// The table `[materials.NAME]` of a material, with its colour if it has one.
pub fn material_table(name: &str, material: &Material, color: Option<Color>) -> String {
    let &Material {
        density,
        restitution,
        friction,
        rolling_friction,
        twisting_friction,
        friction_mix,
        restitution_mix,
    } = material;
    let mix = |mix: Mix| match mix {
        Mix::Average => MIXES[0],
        Mix::GeometricMean => MIXES[1],
        Mix::Minimum => MIXES[2],
        Mix::Product => MIXES[3],
        Mix::Maximum => MIXES[4],
    };
    format!(
        "[materials.{}]\ndensity = {density:?}\nrestitution = {restitution:?}\nfriction = {friction:?}\nrolling_friction = {rolling_friction:?}\n\
         twisting_friction = {twisting_friction:?}\nfriction_mix = \"{}\"\nrestitution_mix = \"{}\"\n{}",
        toml::Value::String(name.to_owned()),
        mix(friction_mix),
        mix(restitution_mix),
        color.map(|color| format!("color = \"{}\"\n", visual::spell(color))).unwrap_or_default()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use rockfall::Solver;
    use rockfall_math::Vec3;

    #[test]
    fn what_is_written_is_read_again() {
        let settings = Settings {
            gravity: Vec3::new(0.1, -1e-7, 3e8),
            rate: 240.0,
            substeps: 7,
            solver: Solver::Reflect,
            integrator: Integrator::SemiImplicit,
            contact_hertz: 33.3,
            contact_damping: 0.7,
            push_speed: 2e5,
            restitution_threshold: 0.0,
            bounce_sweeps: 9,
            sleeping: false,
            sleep_speed: 0.01,
            sleep_time: 2.0,
            continuous: false,
            ..Settings::default()
        };
        let material = Material {
            density: 917.3,
            restitution: 0.25,
            friction: 1.1,
            rolling_friction: 0.003,
            twisting_friction: 1e-6,
            friction_mix: Mix::Product,
            restitution_mix: Mix::Average,
        };
        let color = Some([200, 10, 255]);
        let (world, ice) =
            (world_table(&settings, 12, 99), material_table("dirty \"ice\"", &material, color));
        let text =
            format!("{world}\n{ice}\n[shapes.b]\nkind = \"sphere\"\nradius = 1\n[[bodies]]\nshape = \"b\"\n");
        let scene = Scene::parse(&text, "x", ".").unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((scene.settings, scene.frames, scene.seed), (settings, 12, 99));
        let place = scene.materials().iter().position(|name| name == "dirty \"ice\"").unwrap();
        assert_eq!(scene.plan().unwrap().materials[place], material);
        assert_eq!(scene.plan().unwrap().colors[place], color);
        for mix in [Mix::GeometricMean, Mix::Minimum, Mix::Maximum] {
            let own = Material { friction_mix: mix, ..material };
            let text = text.replace(&ice, &material_table("dirty \"ice\"", &own, None));
            let scene = Scene::parse(&text, "x", ".").unwrap();
            assert_eq!(scene.plan().unwrap().materials[place], own);
        }
    }
}
