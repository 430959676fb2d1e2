//! A scene at work: its world, and what is still to be poured into it.

use crate::body::Template;
use crate::generators::Pour;
use crate::plan::{BodyRow, Plan};
use crate::shapes::bounding_ball;
use crate::visual::{Color, Look};
use rockfall::snapshot::{self, Reader, Writer};
use rockfall::{Body, BodyId, Error, Kind, MaterialId, Settings, Shape, ShapeId, World};
use rockfall_math::{DVec3, Pose, Vec3, rotation::rotate};

/// A world that was built from a scene, and the bodies that will come later.
///
/// Call [`Running::before_step`] before each [`World::step`].
#[derive(Debug)]
pub struct Running {
    /// The world, with all bodies that are there from the start.
    pub world: World,
    shapes: Vec<ShapeId>,
    materials: Vec<MaterialId>,
    colors: Vec<Option<Color>>,
    visuals: Vec<Shape>,
    templates: Vec<Template>,
    rows: Vec<BodyRow>,
    pours: Vec<Pour>,
    /// Bodies that each pour has emitted.
    emitted: Vec<usize>,
    /// The ball around each shape: centre and radius, m.
    balls: Vec<Option<(Vec3, f32)>>,
    rate: f64,
}

impl Running {
    /// Sets up the world of a plan.
    pub(crate) fn new(settings: Settings, plan: Plan) -> Result<Self, Error> {
        let mut world = World::new(settings)?;
        let Plan { shapes, materials, colors, visuals, templates, placed, motions, pours, rows, made: _ } =
            plan;
        let balls = shapes.iter().map(bounding_ball).collect();
        let shapes: Vec<ShapeId> =
            shapes.into_iter().map(|s| world.add_shape(s)).collect::<Result<_, _>>()?;
        let materials: Vec<MaterialId> =
            materials.into_iter().map(|m| world.add_material(m)).collect::<Result<_, _>>()?;
        let emitted = vec![0; pours.len()];
        let mut running = Running {
            world,
            shapes,
            materials,
            colors,
            visuals,
            templates,
            rows,
            pours,
            emitted,
            balls,
            rate: f64::from(settings.rate),
        };
        let body = |(k, &(template, pose)): (usize, &(u32, Pose))| {
            let body = running.body(k, template, pose);
            match motions.get(k) {
                Some(&(velocity, angular_velocity)) => Body { velocity, angular_velocity, ..body },
                None => body,
            }
        };
        let bodies: Vec<Body> = placed.iter().enumerate().map(body).collect();
        let ids = running.world.spawn_all(bodies)?;
        // Those of another run's end are as they were, to the bit; a body that is spawned has its rotation normalized.
        for (id, (&(_, pose), _)) in ids.into_iter().zip(placed.iter().zip(&motions)) {
            running.world.set_pose(id, pose)?;
        }
        Ok(running)
    }

    /// Every body of the scene, those included that are yet to come; ids ascend unless the scene chose some.
    pub fn body_table(&self) -> &[BodyRow] {
        &self.rows
    }

    /// The world's names of the scene's materials, in the order of [`Scene::materials`](crate::Scene::materials).
    pub fn materials(&self) -> &[MaterialId] {
        &self.materials
    }

    /// The colour of each of these materials, where it has one.
    pub fn colors(&self) -> &[Option<Color>] {
        &self.colors
    }

    /// What is seen in place of shapes, in their frames: meshes that [`Look::visual`](crate::Look::visual) of a row counts.
    pub fn visuals(&self) -> &[Shape] {
        &self.visuals
    }

    /// Bodies that have not been poured yet.
    pub fn waiting(&self) -> usize {
        self.pours.iter().zip(&self.emitted).map(|(p, n)| p.rows.len() - n).sum()
    }

    /// Adds a body that the scene does not have, with the id after the largest of the table, which it gets a row in. Its shape is one that the world was given after those of the scene, its
    /// material one of the scene's. A checkpoint can't be loaded any more where it is missing.
    ///
    /// # Errors
    /// Those of [`World::spawn`].
    pub fn add(&mut self, body: Body) -> Result<BodyId, Error> {
        let id = self.rows.iter().map(|row| row.id).max().map_or(1, |id| id.saturating_add(1));
        let material = self.materials.iter().position(|known| *known == body.material).unwrap_or_default();
        let row = BodyRow {
            id,
            name: body.name.clone(),
            shape: body.shape.index(),
            scale: 1.0,
            kind: body.kind,
            sensor: body.sensor,
            material,
            look: Look::default(),
        };
        let id = self.world.spawn(Body { id: Some(BodyId(id)), ..body })?;
        self.rows.push(row);
        Ok(id)
    }

    /// Emits what is due before step `frame`, counted from 0, and says how many bodies that were. Those that find no
    /// room wait for the next frame.
    ///
    /// # Errors
    /// What the world says of a body; the scene's checks leave no reason for it.
    pub fn before_step(&mut self, frame: u64) -> Result<usize, Error> {
        let mut count = 0;
        for p in 0..self.pours.len() {
            if self.pours[p].due(frame, self.rate) > self.emitted[p] {
                let bodies = self.emit(p, frame);
                count += bodies.len();
                self.emitted[p] += bodies.len();
                self.world.spawn_all(bodies)?;
            }
        }
        Ok(count)
    }

    /// Writes how far it is: what each pour has emitted, and the state of the world.
    ///
    /// # Errors
    /// [`snapshot::Error::Io`].
    pub fn save(&self, to: &mut Writer<'_>) -> Result<(), snapshot::Error> {
        // The scene makes the others anew; all random numbers of a pour follow from its seed and the number of a body.
        #[rustfmt::skip]
        let Running {
            world, emitted, rows: _, shapes: _, materials: _, colors: _, visuals: _, templates: _, pours: _, balls: _, rate: _,
        } = self;
        to.column("emitted", &emitted.iter().map(|&count| count as u64).collect::<Vec<u64>>())?;
        world.save(to)
    }

    /// Goes on from where [`Running::save`] was, of the same scene.
    ///
    /// # Errors
    /// Those of [`World::load`], and for a scene with other pours; everything is left as it was.
    pub fn load(&mut self, from: &mut Reader<'_>) -> Result<(), snapshot::Error> {
        let emitted: Vec<u64> = from.column("emitted")?;
        let due =
            |(&count, pour): (&u64, &Pour)| usize::try_from(count).ok().filter(|&n| n <= pour.rows.len());
        let counts: Option<Vec<usize>> = emitted.iter().zip(&self.pours).map(due).collect();
        let counts = counts.filter(|_| emitted.len() == self.pours.len());
        let counts = counts.ok_or(snapshot::Error::OtherWorld("pours"))?;
        self.world.load(from)?;
        self.emitted = counts;
        Ok(())
    }

    /// The bodies of pour `p` that are due and find room.
    fn emit(&self, p: usize, frame: u64) -> Vec<Body> {
        let pour = &self.pours[p];
        let mut balls = self.balls_near(pour);
        let mut bodies = Vec::new();
        for k in self.emitted[p]..pour.due(frame, self.rate) {
            let row = pour.rows.start + k;
            let Some((centre, radius)) = self.balls[self.rows[row].shape] else { break };
            let radius = f64::from(radius);
            let clear =
                |at: &DVec3| balls.iter().all(|(other, r)| (*other - *at).length() >= r + radius + pour.gap);
            let Some(place) = pour.candidates(k, frame, radius).find(clear) else { break };
            balls.push((place, radius));
            let rotation = pour.rotation(k);
            let position = place - rotate(rotation, centre).as_dvec3();
            bodies.push(self.body(row, pour.template, Pose { position, rotation }));
        }
        bodies
    }

    /// The balls around all bodies that can move and are near the region of a pour.
    fn balls_near(&self, pour: &Pour) -> Vec<(DVec3, f64)> {
        let (poses, shapes, kinds) = (self.world.poses(), self.world.shapes_of_bodies(), self.world.kinds());
        let ball = |((pose, shape), kind): ((&Pose, &ShapeId), &Kind)| {
            let (centre, radius) = self.balls.get(shape.index()).copied().flatten()?;
            let (centre, radius) = (pose.point(centre), f64::from(radius));
            (*kind != Kind::Static && pour.is_near(centre, radius)).then_some((centre, radius))
        };
        poses.iter().zip(&shapes).zip(&kinds).filter_map(ball).collect()
    }

    fn body(&self, row: usize, template: u32, pose: Pose) -> Body {
        let (row, template) = (&self.rows[row], &self.templates[template as usize]);
        Body {
            id: Some(BodyId(row.id)),
            name: row.name.clone(),
            kind: template.kind,
            shape: self.shapes[row.shape],
            material: self.materials[template.material as usize],
            pose,
            velocity: template.velocity,
            angular_velocity: template.angular_velocity,
            gravity_scale: template.gravity_scale,
            linear_damping: template.linear_damping,
            angular_damping: template.angular_damping,
            locks: template.locks,
            group: template.group,
            mask: template.mask,
            sensor: template.sensor,
            mass: template.mass,
        }
    }
}
