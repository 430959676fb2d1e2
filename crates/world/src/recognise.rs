//! Which of a pair's new contacts are old ones: those go on with their impulses.
//!
//! Reads the manifolds that were found and those that were there; writes what each new one remembers, and in whose place it goes on.
//!
//! A point takes the impulse of its namesake. Where two faces cover each other, as in a tower of equal boxes, rounding decides which corner or crossing of edges names a
//! point, and names change from step to step; so a point without a namesake takes the impulse of the nearest point that is left. The points of fields go from one manifold of
//! their pair to another: what counts is where and which way a point pushes, not in which company; no impulse is taken twice, and friction goes where the normal impulses go. Done for hulls on triangles and for compounds as well, it
//! slowed what runs through a pipe of triangles and let a bowl of hulls rock on; those keep to one manifold.

use rockfall_solve::{Manifold, Memory};

/// How far a point may have gone in a step to be taken for the same under a new name, as a share of its arm.
const SAME: f32 = 0.05;

/// Cosine of the largest angle between the normals of two manifolds of which one goes on as the other: 26°.
const ALIKE: f32 = 0.9;

/// A contact and what is remembered of it.
type Known = (Manifold, Memory);

/// Room for the work, kept from pair to pair.
#[derive(Debug, Default)]
pub(crate) struct Recognition {
    /// In whose place each new manifold goes on, and which of its points have found their impulse.
    news: Vec<(Option<usize>, [bool; 4])>,
    /// Whether each old manifold goes on in its place, and which of its points are taken.
    olds: Vec<(bool, [bool; 4])>,
    /// Whether points go from one manifold to another.
    gives: bool,
    /// Of each old manifold, the normal impulses that each new one has taken; new ones run fastest.
    taken: Vec<f32>,
}

impl Recognition {
    /// In whose place new manifold number `n` goes on.
    pub(crate) fn source(&self, n: usize) -> Option<usize> {
        self.news[n].0
    }

    /// Whether old manifold number `i` goes on.
    pub(crate) fn goes_on(&self, i: usize) -> bool {
        self.olds[i].0
    }

    /// Gives the new manifolds, whose names are set, what is remembered of the old ones. Points with other names that are further apart than `reach` metres, or a
    /// twentieth of their arm where that is more, are different points. With a `reach`, which concave bodies have, points may change manifolds.
    pub(crate) fn recognise(&mut self, news: &mut [Known], olds: &[Known], reach: f32) {
        self.news.clear();
        self.news.resize(news.len(), Default::default());
        self.olds.clear();
        self.olds.resize(olds.len(), Default::default());
        self.taken.clear();
        self.taken.resize(news.len() * olds.len(), 0.0);
        self.gives = false;
        if reach > 0.0 {
            self.over_all(news, olds, reach);
        } else {
            (0..news.len()).for_each(|n| self.within_one(n, &mut news[n], olds));
        }
    }

    /// The points of a new manifold are those of one old one: of the first that has a namesake, or of the only one, whatever they are called and wherever it looks.
    fn within_one(&mut self, n: usize, new: &mut Known, olds: &[Known]) {
        let named = |old: &Known| names(new).any(|name| namesake(name, old).is_some());
        let Some(i) = olds.iter().position(named).or((olds.len() == 1).then_some(0)) else { return };
        let goes_on = self.olds[i].0;
        self.olds[i].1 = [false; 4];
        self.news[n].0 = Some(i);
        self.by_name(n, new, olds);
        self.by_nearness(n, new, olds, 0.0);
        let old = &olds[i].1;
        (new.1.friction, new.1.twist, new.1.rolling) = (old.friction, old.twist, old.rolling);
        // Of two that both know an old one the first goes on in its place.
        self.news[n].0 = Some(i).filter(|_| !goes_on);
        self.olds[i].0 = true;
    }

    /// Points go from one manifold to another that pushes the same way, and none is taken twice.
    fn over_all(&mut self, news: &mut [Known], olds: &[Known], reach: f32) {
        self.gives = true;
        for (n, new) in news.iter().enumerate() {
            self.go_on(n, olds, |old| names(new).any(|name| namesake(name, old).is_some()));
        }
        for (n, new) in news.iter().enumerate() {
            self.go_on(n, olds, |old| olds.len() == 1 || alike(new, old));
        }
        for (n, new) in news.iter_mut().enumerate() {
            self.by_name(n, new, olds);
        }
        for (n, new) in news.iter_mut().enumerate() {
            self.by_nearness(n, new, olds, reach);
        }
        self.share(news, olds);
    }

    /// Lets a new manifold that has no place yet go on in that of the first old one that is fit and left.
    fn go_on(&mut self, n: usize, olds: &[Known], fit: impl Fn(&Known) -> bool) {
        if self.news[n].0.is_none()
            && let Some(i) = (0..olds.len()).find(|&i| !self.olds[i].0 && fit(&olds[i]))
        {
            self.news[n].0 = Some(i);
            self.olds[i].0 = true;
        }
    }

    /// Old manifolds from which a new one may take points: that in whose place it goes on, then those that push the same way.
    fn givers<'a>(
        &self,
        n: usize,
        new: &'a Known,
        olds: &'a [Known],
    ) -> impl Iterator<Item = usize> + use<'a> {
        let source = self.news[n].0;
        let others = if self.gives { olds.len() } else { 0 };
        let others = (0..others).filter(move |&i| Some(i) != source && alike(new, &olds[i]));
        source.into_iter().chain(others)
    }

    fn by_name(&mut self, n: usize, new: &mut Known, olds: &[Known]) {
        for p in 0..new.0.count as usize {
            let name = new.1.features[p];
            let free = self.givers(n, new, olds).find_map(|i| {
                let q = namesake(name, &olds[i])?;
                (!self.olds[i].1[q]).then_some((i, q))
            });
            self.pass(n, p, new, olds, free);
        }
    }

    fn by_nearness(&mut self, n: usize, new: &mut Known, olds: &[Known], reach: f32) {
        for p in 0..new.0.count as usize {
            if self.news[n].1[p] {
                continue;
            }
            let arm = new.0.arms[p];
            let mut nearest = ((SAME * SAME * arm.length_squared()).max(reach * reach), None);
            for i in self.givers(n, new, olds) {
                let old = &olds[i].0;
                for q in (0..old.count as usize).filter(|&q| !self.olds[i].1[q]) {
                    let way = (old.arms[q] - arm).length_squared();
                    if way < nearest.0 {
                        nearest = (way, Some((i, q)));
                    }
                }
            }
            self.pass(n, p, new, olds, nearest.1);
        }
    }

    /// Passes the impulse of point `q` of old manifold `i` on to point `p` of a new one.
    fn pass(&mut self, n: usize, p: usize, new: &mut Known, olds: &[Known], from: Option<(usize, usize)>) {
        let Some((i, q)) = from else { return };
        let impulse = olds[i].1.normals[q];
        new.1.normals[p] = impulse;
        (self.news[n].1[p], self.olds[i].1[q]) = (true, true);
        self.taken[i * self.news.len() + n] += impulse;
    }

    /// Shares out what old manifolds know besides normal impulses, by these; where there are none it stays in its place.
    fn share(&self, news: &mut [Known], olds: &[Known]) {
        for (taken, (i, (_, old))) in self.taken.chunks_exact(news.len().max(1)).zip(olds.iter().enumerate())
        {
            let all: f32 = taken.iter().sum();
            for (n, (_, memory)) in news.iter_mut().enumerate() {
                let share = match all > 0.0 {
                    true => taken[n] / all,
                    false => f32::from(u8::from(self.news[n].0 == Some(i))),
                };
                if share > 0.0 {
                    memory.friction += share * old.friction;
                    memory.twist += share * old.twist;
                    memory.rolling += share * old.rolling;
                }
            }
        }
    }
}

fn names((manifold, memory): &Known) -> impl Iterator<Item = u32> {
    memory.features.into_iter().take(manifold.count as usize)
}

fn namesake(name: u32, old: &Known) -> Option<usize> {
    names(old).position(|other| other == name)
}

fn alike(one: &Known, other: &Known) -> bool {
    one.0.normal.dot(other.0.normal) > ALIKE
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::Vec3;

    /// Points on a line along y, of names and impulses.
    fn known(normal: Vec3, points: &[(f32, u32, f32)]) -> Known {
        let mut manifold = Manifold { normal, count: points.len() as u32, ..Manifold::default() };
        let mut memory = Memory::default();
        for (p, &(y, name, impulse)) in points.iter().enumerate() {
            manifold.arms[p] = Vec3::new(1.0, y, 0.0);
            (memory.features[p], memory.normals[p]) = (name, impulse);
        }
        memory.friction = Vec3::X * memory.normals.iter().sum::<f32>();
        (manifold, memory)
    }

    fn recognised(mut news: Vec<Known>, olds: &[Known], reach: f32) -> (Vec<Known>, Vec<Option<usize>>) {
        let mut recognition = Recognition::default();
        news.iter_mut().for_each(|(_, memory)| (memory.normals, memory.friction) = ([0.0; 4], Vec3::ZERO));
        recognition.recognise(&mut news, olds, reach);
        let sources = (0..news.len()).map(|n| recognition.source(n)).collect();
        (news, sources)
    }

    #[test]
    fn points_keep_their_impulse_by_name_and_else_by_nearness() {
        let olds = [known(Vec3::Z, &[(0.0, 1, 1.0), (1.0, 2, 2.0), (2.0, 3, 4.0)])];
        let news = vec![known(Vec3::Z, &[(0.0, 3, 0.0), (0.99, 9, 0.0), (5.0, 8, 0.0)])];
        let (news, sources) = recognised(news, &olds, 0.0);
        assert_eq!(sources, [Some(0)]);
        assert_eq!(news[0].1.normals, [4.0, 2.0, 0.0, 0.0]);
        assert_eq!(news[0].1.friction, 7.0 * Vec3::X);
        // The one left over is too far away, unless names reach so far.
        let (news, _) = recognised(news, &olds, 6.0);
        assert_eq!(news[0].1.normals, [4.0, 2.0, 1.0, 0.0]);
    }

    #[test]
    fn points_go_from_one_manifold_to_another_that_pushes_the_same_way() {
        let tilted = Vec3::new(0.3, 0.0, 1.0).normalize();
        let olds = [known(Vec3::Z, &[(0.0, 1, 1.0), (1.0, 2, 3.0)]), known(Vec3::X, &[(0.5, 5, 8.0)])];
        let news = vec![
            known(tilted, &[(1.0, 2, 0.0)]),
            known(Vec3::Z, &[(0.0, 1, 0.0)]),
            known(Vec3::X, &[(0.5, 7, 0.0)]),
        ];
        let (news, sources) = recognised(news, &olds, 1e-3);
        assert_eq!(sources, [Some(0), None, Some(1)]);
        assert_eq!([0, 1, 2].map(|n| news[n].1.normals[0]), [3.0, 1.0, 8.0]);
        assert_eq!([0, 1, 2].map(|n| news[n].1.friction.x), [3.0, 1.0, 8.0]);
    }

    #[test]
    fn no_impulse_is_taken_twice() {
        let olds = [known(Vec3::Z, &[(0.0, 1, 1.0)])];
        let news = vec![known(Vec3::Z, &[(0.0, 1, 0.0)]), known(Vec3::Z, &[(0.0, 1, 0.0), (0.01, 4, 0.0)])];
        let (news, sources) = recognised(news, &olds, 1.0);
        assert_eq!(sources, [Some(0), None]);
        let all = |of: fn(&Known) -> f32| news.iter().map(of).sum::<f32>();
        assert_eq!(all(|(_, memory)| memory.normals.iter().sum()), 1.0);
        assert_eq!(all(|(_, memory)| memory.friction.x), 1.0);
    }
}
