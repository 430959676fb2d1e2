//! Contact of two fields by the corners and edges of their meshes.
//!
//! Two solids with flat sides touch where a corner of one meets the other, or where two edges cross. The samples of both tell which corners and edges are near
//! the other body, without a look at the rest; what is told of those is exact, and has the same name as long as they meet. A point of the surface that is only near that place would be off by as much as the two surfaces
//! bend away from each other on the way, and bodies that hang in each other would be kept trembling by it.
//!
//! A corner counts where the way to the other body lies within the normals of the sides around it, two edges where their common normal lies within those of both: there, nothing beside them is nearer.

use super::SLACK;
use super::deep::{self, Sunk};
use super::edges::{Edge, may_cross};
use super::gather::{Contact, FACING, NEARLY, WORTH, within};
use super::side::{Near, Side};
use rockfall_math::{Vec3, hash, trig};
use rockfall_shape::{Feature, Field, SAMPLES_IN_A_BALL};

/// Edges whose directions have a smaller sine of the angle between them are parallel: corners carry them.
const PARALLEL: f32 = 0.03;

/// Samples nearer than this share of their spacing tell of what is touched.
const NEAR: f32 = 0.5;

/// Between samples of bodies that are further apart a surface may be nearer by this share of the spacing.
const BETWEEN: f32 = 0.25;

/// The most by which edges that cross overlap, in spacings of the samples.
const OVERLAP: f32 = 1.25;

/// Share of the depth that two edges would have below each other's sides, if nothing else were near.
const DEEP: f32 = 0.9;

/// So much of the spacing a point of an edge that lies in a side may stick out of it.
const ROUNDING: f32 = 1e-2;

/// Where a field is steeper than this all ways out of a cell are alike: its slope is their mean. There, the way out of a corner that is no deeper than the spacing is no further from that than by the angle with this cosine and sine, 30°, so that many
/// corners near the other body need no exact distance to be told that they look past it.
const STEEP: f32 = 0.9;
const TURNED: [f32; 2] = [0.866, 0.5];

/// Kinds of names: of a corner, of two edges, of a sample; besides of which body.
const OF_EDGES: u32 = 1 << 30;
const OF_SAMPLES: u32 = 1 << 29;
const OF_ONE: u32 = OF_SAMPLES - 1;

/// Two fields.
pub(super) struct Two<'a, 'b> {
    pub(super) sides: [&'a Side<'b>; 2],
    pub(super) fields: [&'a Field; 2],
    pub(super) margin: f32,
    /// Samples up to there are looked at.
    pub(super) reach: f32,
    pub(super) spacing: f32,
}

/// A corner that may lie in the other body and does not face it.
struct Hidden {
    /// Of which body it is.
    k: usize,
    vertex: u32,
    /// What the field of the other says of its distance, metres.
    about: f32,
}

impl Two<'_, '_> {
    /// Appends the contacts. Returns how far apart the two are at least, as far as their samples know.
    pub(super) fn contacts(&self, out: &mut Vec<Contact>) -> f32 {
        let mut edges = [Vec::new(), Vec::new()];
        let (mut hidden, mut sunk) = (Vec::new(), Vec::new());
        let mut least = f32::INFINITY;
        for (k, edges) in edges.iter_mut().enumerate() {
            let mut features = Vec::new();
            least = least.min(self.near(k, &mut features, out, &mut sunk));
            for feature in features {
                match feature {
                    Feature::Corner(vertex) => self.corner(k, vertex, out, &mut hidden),
                    Feature::Edge(number) => edges.push(self.edge(k, number)),
                }
            }
        }
        self.crossings(&edges, out);
        // Where two bodies overlap and nothing else touches there is a contact, whichever way the surfaces look: of several, the deepest.
        if out.iter().all(|contact| contact.distance > 0.0) {
            let deep = hidden.into_iter().filter_map(|corner| self.hidden(corner));
            out.extend(deep.reduce(|one, two| if two.distance < one.distance { two } else { one }));
        }
        deep::part(self, &sunk, out);
        least
    }

    /// How far apart the two surely are, metres, which have no contact, and of whose samples none is nearer than `least`. Two bodies that rest beside each other would be looked at in every step
    /// if nothing were known but that they don't touch.
    pub(super) fn apart(&self, least: f32) -> f32 {
        let least = if least > self.reach { self.gap() } else { least };
        let by_samples = least - SLACK * self.spacing;
        if by_samples > self.margin {
            return by_samples;
        }
        // Where samples are near, corners and edges tell; everywhere else they are as far away as that.
        let elsewhere = (least.max(NEAR * self.spacing) - BETWEEN * self.spacing).max(0.0);
        let mut further = Vec::new();
        Two { margin: self.margin.max(elsewhere), ..*self }.contacts(&mut further);
        further.iter().fold(elsewhere, |nearest, contact| nearest.min(contact.distance)).max(0.0)
    }

    /// How far the samples of one are from the other at least, metres, where all are out of reach: balls that are near for their size are looked into.
    fn gap(&self) -> f32 {
        let mut least = f32::INFINITY;
        for k in 0..2 {
            let (own, field, other, beyond) = self.of(k);
            let mut in_balls = f32::INFINITY;
            field.samples().search(
                |balls| {
                    let surely = beyond.least_distances(balls, &own.place, &other.place);
                    std::array::from_fn(|i| {
                        let inside = surely[i] - balls[3][i];
                        if inside < WORTH * surely[i] {
                            return f32::NEG_INFINITY;
                        }
                        in_balls = in_balls.min(inside);
                        f32::INFINITY
                    })
                },
                |bound| bound < f32::INFINITY,
                |_, points| {
                    let distances = beyond.distances_below(points, &own.place, &other.place, self.reach);
                    distances.into_iter().for_each(|d| least = least.min(d.unwrap_or_else(|surely| surely)));
                },
            );
            least = least.min(in_balls);
        }
        least
    }

    /// Body number `k`, and the other one.
    fn of(&self, k: usize) -> (&Side<'_>, &Field, &Side<'_>, &Field) {
        (self.sides[k], self.fields[k], self.sides[1 - k], self.fields[1 - k])
    }

    /// Collects the features of a body that its samples know to be near the other one, ascending. Of what is further away, or deep in it, the nearest sample of each small ball stands for the others, since bodies that come fast see
    /// hundreds; further away it is enough to meet it as exactly as the field says. Returns how far all others are at least.
    fn near(
        &self,
        k: usize,
        features: &mut Vec<Feature>,
        out: &mut Vec<Contact>,
        sunk: &mut Vec<Sunk>,
    ) -> f32 {
        let (own, field, other, there) = self.of(k);
        let mut least = f32::INFINITY;
        let mut near: Vec<(usize, f32)> = Vec::new();
        let mut beyond = f32::INFINITY;
        field.samples().search(
            |balls| other.least_gaps(balls, &own.place),
            |gap| {
                if gap > self.reach {
                    least = least.min(gap);
                }
                gap <= self.reach
            },
            |numbers, points| {
                let distances = there.distances_below(points, &own.place, &other.place, self.reach);
                for (i, distance) in numbers.zip(distances) {
                    match distance {
                        Ok(distance) => near.push((i, distance)),
                        Err(surely) => beyond = beyond.min(surely),
                    }
                }
            },
        );
        least = least.min(beyond);
        let is_in = near.iter().filter(|(_, distance)| *distance < 0.0);
        sunk.extend(is_in.map(|&(number, distance)| Sunk { k, number, distance }));
        for ball in near.chunk_by(|(i, _), (j, _)| i / SAMPLES_IN_A_BALL == j / SAMPLES_IN_A_BALL) {
            let touching = |&&(_, distance): &&(usize, f32)| distance <= NEAR * self.spacing;
            ball.iter().filter(touching).for_each(|&(i, _)| features.extend(field.features().near(i)));
            let first = ball.iter().reduce(|one, two| if two.1 < one.1 { two } else { one });
            let Some(&(i, distance)) = first else { continue };
            least = least.min(distance);
            let by_features = (-self.spacing..=NEAR * self.spacing).contains(&distance);
            if !by_features && distance <= self.margin {
                out.extend(self.sample(k, i));
            }
        }
        features.sort_unstable();
        features.dedup();
        least
    }

    pub(super) fn sample_name(&self, i: usize) -> u32 {
        i as u32 & OF_ONE | OF_SAMPLES
    }

    fn sample(&self, k: usize, i: usize) -> Option<Contact> {
        let (own, field, other, _) = self.of(k);
        let sample = &field.samples().points()[i];
        let p = own.place.point(sample.position);
        let about = other.nearest(p, self.reach)?;
        let (there, beside) = match about.distance > 0.0 {
            true => (about, NEARLY),
            false => (other.exact(p, about.distance)?, FACING),
        };
        let facing = own.place.vector(sample.normal).dot(-there.normal);
        let name = self.sample_name(i);
        within(facing, sample.cone, beside).then(|| Contact::new(k == 1, p, there, name))
    }

    /// A corner at the other body. One that may lie in it, and does not face it, is `hidden`.
    fn corner(&self, k: usize, vertex: u32, out: &mut Vec<Contact>, hidden: &mut Vec<Hidden>) {
        let (own, field, other, beyond) = self.of(k);
        let p = own.place.point(field.mesh().vertices[vertex as usize]);
        let Ok((about, slope)) = beyond.slope_below(other.place.inverse_point(p), self.margin) else {
            return;
        };
        if about > self.margin + beyond.bound(about) {
            return;
        }
        let normals = field.features().corner(vertex);
        let facing = |out: Vec3| own.place.vector(normals.out).dot(-out);
        let steep = slope.length();
        let is_clear = steep >= STEEP && about > -self.spacing;
        let may_face = !is_clear || within(facing(other.place.vector(slope)) / steep, normals.cone, TURNED);
        let there = if may_face { other.exact(p, about) } else { None };
        match there {
            Some(there) if there.distance > self.margin => {}
            Some(there) if within(facing(there.normal), normals.cone, FACING) => {
                out.push(Contact::new(k == 1, p, there, vertex & OF_ONE));
            }
            _ if about <= beyond.bound(about) => hidden.push(Hidden { k, vertex, about }),
            _ => {}
        }
    }

    /// The contact of a corner whichever way it looks, if it lies in the other body.
    fn hidden(&self, Hidden { k, vertex, about }: Hidden) -> Option<Contact> {
        let (own, field, other, _) = self.of(k);
        let p = own.place.point(field.mesh().vertices[vertex as usize]);
        let there = other.exact(p, about).filter(|there| there.distance <= 0.0)?;
        Some(Contact::new(k == 1, p, there, vertex & OF_ONE))
    }

    /// An edge in A's frame.
    fn edge(&self, k: usize, number: u32) -> Edge {
        let (own, field) = (self.sides[k], self.fields[k]);
        let edge = field.features().edges()[number as usize];
        let ends = edge.ends.map(|v| own.place.point(field.mesh().vertices[v as usize]));
        let out = own.place.vector(edge.normals.out);
        let cone = edge.normals.cone;
        let ([beside, sine], flat) = (FACING, (1.0 - cone * cone).max(0.0).sqrt());
        let open = cone <= -beside;
        let faces =
            if open { [-1.0, 0.0] } else { [cone * beside - flat * sine, flat * beside + cone * sine] };
        Edge { number, ends, out, cone, faces }
    }

    fn crossings(&self, [ones, twos]: &[Vec<Edge>; 2], out: &mut Vec<Contact>) {
        let most = self.margin.max(OVERLAP * self.spacing);
        let pairs = may_cross(ones, twos, most);
        out.extend(pairs.into_iter().filter_map(|[i, j]| self.crossing(&ones[i], &twos[j])));
    }

    /// The contact of two edges that cross.
    fn crossing(&self, one: &Edge, two: &Edge) -> Option<Contact> {
        let (on_one, on_two, normal) = crossing(one.ends, two.ends, one.out, 0.0)?;
        let distance = normal.dot(on_two - on_one);
        let faces = |edge: &Edge, cosine: f32| within(cosine, edge.cone, FACING);
        if distance > self.margin || !faces(one, normal.dot(one.out)) || !faces(two, -normal.dot(two.out)) {
            return None;
        }
        let overlap = -distance / self.spacing;
        if overlap > OVERLAP {
            return None;
        }
        // A crossing that is deep is one only where each edge lies as deep below the other body's sides as their common normal says: otherwise a shorter way parts them. Where it is not, other sides of a fine mesh may be as
        // near, and it is enough that each lies in the other body.
        let is_in = |k: usize, p: Vec3, edge: &Edge, cosine: f32| {
            if overlap <= NEAR {
                let error = self.fields[k].settings().error;
                return self.sides[k].distance(p, 0.0).is_some_and(|distance| distance <= error);
            }
            let turned = trig::acos(edge.cone.clamp(-1.0, 1.0)) + trig::acos(cosine.clamp(-1.0, 1.0));
            let below = trig::sin_cos(turned).1.max(0.0) * DEEP * distance + ROUNDING * self.spacing;
            self.sides[k].exact(p, distance).is_some_and(|there| there.distance <= below)
        };
        let both =
            || is_in(1, on_one, two, -normal.dot(two.out)) && is_in(0, on_two, one, normal.dot(one.out));
        if overlap > 0.0 && !both() {
            return None;
        }
        let name = hash::combine(u64::from(one.number), u64::from(two.number)) as u32;
        let contact =
            Contact::new(false, on_one, Near { distance, normal: -normal }, name & OF_ONE | OF_EDGES);
        Some(Contact { position: 0.5 * (on_one + on_two), ..contact })
    }
}

/// The nearest points of two edges, if they are further in than the ends or no further beyond them than `slack` metres, and their common normal, on the side of `out`.
pub(crate) fn crossing(one: [Vec3; 2], two: [Vec3; 2], out: Vec3, slack: f32) -> Option<(Vec3, Vec3, Vec3)> {
    let [u, v] = [one, two].map(|ends| ends[1] - ends[0]);
    let between = two[0] - one[0];
    let cross = u.cross(v);
    let squared = cross.length_squared();
    if squared <= PARALLEL * PARALLEL * u.length_squared() * v.length_squared() {
        return None;
    }
    let s = between.cross(v).dot(cross) / squared;
    let t = between.cross(u).dot(cross) / squared;
    let is_on = |share: f32, along: Vec3| {
        let beyond = if slack > 0.0 { slack / along.length() } else { 0.0 };
        (-beyond..=1.0 + beyond).contains(&share)
    };
    if !is_on(s, u) || !is_on(t, v) {
        return None;
    }
    let normal = cross / squared.sqrt();
    let normal = if normal.dot(out) < 0.0 { -normal } else { normal };
    Some((one[0] + s * u, two[0] + t * v, normal))
}
