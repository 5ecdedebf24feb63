//! Where every body of a world state is, with a version for each thing that moves as one: the ground on which the memory of facts
//! decides what has moved.
//!
//! A version is a small number of a place, to the last bit: two states in which a thing has the same version have it at the same
//! place (and held by the same hand); the same place mostly has the same version.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::super::prepared::{Owner, Part, Prepared};
use crate::geom::{Pose, Vec3};
use crate::world::{AgentState, EntityRef, ObjectState, Scene, State};

/// What moves as one: a link that has bodies, or an object.
#[derive(Debug, Clone)]
pub(super) struct Item {
    pub owner: Owner,
    /// Positions of its bodies in [`Layout::placed`].
    bodies: std::ops::Range<usize>,
}

/// The items of a scene, and the numbers of their places.
#[derive(Debug)]
pub(super) struct Items {
    pub all: Vec<Item>,
    /// By body: its position among the parts of its agent or object.
    parts: Vec<usize>,
    /// By agent and link.
    links: Vec<Vec<Option<usize>>>,
    first_object: usize,
    /// By item: places with their versions.
    places: Vec<FxHashMap<[u64; 9], u32>>,
    /// By agent: configurations with base poses.
    configurations: Vec<FxHashMap<Vec<u64>, u32>>,
    /// The next version; none is used twice.
    next: u32,
}

/// Places that are remembered for one item before its memory begins again.
const MOST_PLACES: usize = 20_000;

/// Where every body of a world state is.
#[derive(Debug)]
pub(in crate::grp) struct Layout {
    /// Of every agent.
    pub(super) X_WL: Vec<Vec<Pose>>,
    /// X_WS of every body, by item.
    pub(super) placed: Vec<Pose>,
    /// By item; those of agents' configurations behind.
    pub(super) versions: Vec<u32>,
    /// By agent, then by object: the box around it, along the axes of W: lower and upper corner [m].
    pub(super) boxes: Vec<[Vec3; 2]>,
}

impl Items {
    pub(super) fn new(scene: &Scene, prepared: &Prepared) -> Items {
        let (mut all, mut parts): (Vec<Item>, Vec<usize>) = (Vec::new(), Vec::new());
        let mut links = Vec::new();
        let mut add = |owner: Owner, of: Vec<usize>| {
            let begin = parts.len();
            parts.extend(of);
            let bodies = begin..parts.len();
            all.push(Item { owner, bodies });
            all.len() - 1
        };
        for (agent, body) in scene.agents.iter().enumerate() {
            let of = |link: usize| {
                let own = prepared.agents[agent].parts.iter().enumerate();
                own.filter(|(_, p)| p.link == link).map(|(i, _)| i).collect::<Vec<_>>()
            };
            let items = (0..body.tree.links.len()).map(|link| {
                let of = of(link);
                (!of.is_empty()).then(|| add(Owner::Link { agent, link }, of))
            });
            links.push(items.collect());
        }
        let mut first_object = None;
        for object in 0..scene.objects.len() {
            let item = add(Owner::Object(object), (0..prepared.objects[object].len()).collect());
            first_object.get_or_insert(item);
        }
        let n = all.len();
        Items {
            places: vec![FxHashMap::default(); n],
            configurations: vec![FxHashMap::default(); scene.agents.len()],
            first_object: first_object.unwrap_or(n),
            all,
            parts,
            links,
            next: 0,
        }
    }

    /// Returns the item of a body's owner; `None` for a link without bodies.
    pub(super) fn of(&self, owner: Owner) -> Option<usize> {
        match owner {
            Owner::Link { agent, link } => self.links[agent][link],
            Owner::Object(object) => Some(self.first_object + object),
        }
    }

    /// Returns the bodies of an item: their shapes and positions in [`Layout::placed`].
    pub(super) fn bodies<'p>(
        &self,
        prepared: &'p Prepared,
        item: usize,
    ) -> impl Iterator<Item = (&'p Part, usize)> + use<'p, '_> {
        let Item { owner, ref bodies } = self.all[item];
        let parts: &'p [Part] = match owner {
            Owner::Link { agent, .. } => &prepared.agents[agent].parts,
            Owner::Object(object) => &prepared.objects[object],
        };
        bodies.clone().map(move |body| (&parts[self.parts[body]], body))
    }

    /// Returns where everything is. What has not moved since `before` is taken over.
    fn layout(
        &mut self,
        scene: &Scene,
        prepared: &Prepared,
        state: &State,
        before: Option<(&State, &Layout)>,
    ) -> Layout {
        let n = self.all.len();
        let mut layout = Layout {
            X_WL: Vec::with_capacity(scene.agents.len()),
            placed: vec![Pose::identity(); self.parts.len()],
            versions: vec![0; n + scene.agents.len()],
            boxes: vec![
                [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
                scene.agents.len() + state.objects.len()
            ],
        };
        for (a, agent) in state.agents.iter().enumerate() {
            let known = before.filter(|(before, _)| before.agents[a] == *agent);
            let links = self.links[a].iter().flatten().copied();
            if let Some((_, known)) = known {
                layout.X_WL.push(known.X_WL[a].clone());
                layout.versions[n + a] = known.versions[n + a];
                for item in links {
                    let bodies = self.all[item].bodies.clone();
                    layout.versions[item] = known.versions[item];
                    layout.placed[bodies.clone()].copy_from_slice(&known.placed[bodies]);
                }
                layout.boxes[a] = known.boxes[a];
                continue;
            }
            let X_WL = scene.agents[a].tree.link_poses(&agent.X_WB, &agent.q);
            let links: Vec<usize> = links.collect();
            for item in links {
                if let Owner::Link { link, .. } = self.all[item].owner {
                    self.put(prepared, item, &X_WL[link], 0, a, &mut layout);
                }
            }
            layout.X_WL.push(X_WL);
            layout.versions[n + a] = self.configuration(a, agent);
        }
        for (o, object) in state.objects.iter().enumerate() {
            let item = self.first_object + o;
            let entity = state.agents.len() + o;
            match before.filter(|(before, _)| before.objects[o] == *object) {
                Some((_, known)) => {
                    let bodies = self.all[item].bodies.clone();
                    layout.versions[item] = known.versions[item];
                    layout.placed[bodies.clone()].copy_from_slice(&known.placed[bodies]);
                    layout.boxes[entity] = known.boxes[entity];
                }
                None => self.put(prepared, item, &object.X_WO, holder(object), entity, &mut layout),
            }
        }
        layout
    }

    /// Places the bodies of an item whose frame is at `X_WF`.
    fn put(&mut self, prepared: &Prepared, item: usize, X_WF: &Pose, holder: u64, entity: usize, layout: &mut Layout) {
        let [mut low, mut high] = layout.boxes[entity];
        for (part, body) in self.bodies(prepared, item) {
            let X_WS = X_WF * part.X_FS;
            let half = part.exact.half_extent(&X_WS);
            low = low.inf(&(X_WS.translation.vector - half));
            high = high.sup(&(X_WS.translation.vector + half));
            layout.placed[body] = X_WS;
        }
        layout.boxes[entity] = [low, high];
        let (t, r) = (X_WF.translation.vector, X_WF.rotation.coords);
        let [x, y, z] = [t.x, t.y, t.z].map(f64::to_bits);
        let [i, j, k, w] = [r.x, r.y, r.z, r.w].map(f64::to_bits);
        let place = [x, y, z, i, j, k, w, holder, 0];
        layout.versions[item] = version(&mut self.places[item], place, &mut self.next);
    }

    fn configuration(&mut self, agent: usize, state: &AgentState) -> u32 {
        let (t, r) = (state.X_WB.translation.vector, state.X_WB.rotation.coords);
        let base = [t.x, t.y, t.z, r.x, r.y, r.z, r.w];
        let all = base.iter().chain(&state.q).map(|x| x.to_bits()).collect();
        version(&mut self.configurations[agent], all, &mut self.next)
    }
}

fn version<K: std::hash::Hash + Eq>(known: &mut FxHashMap<K, u32>, place: K, next: &mut u32) -> u32 {
    if known.len() >= MOST_PLACES {
        known.clear();
    }
    *known.entry(place).or_insert_with(|| {
        *next = next.saturating_add(1);
        *next
    })
}

/// A number of the hand that holds an object, 0 for none.
fn holder(object: &ObjectState) -> u64 {
    let hand = |agent: usize, arm: usize| 1 + 2 * agent as u64 + arm as u64;
    object.held.as_ref().map_or(0, |h| hand(h.agent, h.arm))
}

impl Layout {
    /// Returns the version of an agent's configuration and base, or of an object's place and holder.
    pub(super) fn version(&self, items: &Items, entity: EntityRef) -> u32 {
        match entity {
            EntityRef::Agent(a) => self.versions[items.all.len() + a],
            EntityRef::Object(o) => self.versions[items.first_object + o],
            EntityRef::Virtual(_) => 0,
        }
    }

    /// Returns a lower bound of the distance between two entities that are somewhere [m].
    pub(super) fn at_least_apart(&self, a: EntityRef, b: EntityRef) -> f64 {
        let n = self.X_WL.len();
        let of = |entity: EntityRef| match entity {
            EntityRef::Agent(a) => self.boxes.get(a),
            EntityRef::Object(o) => self.boxes.get(n + o),
            EntityRef::Virtual(_) => None,
        };
        match (of(a), of(b)) {
            (Some([low, high]), Some([below, above])) => {
                let gap = (low - above).sup(&(below - high));
                gap.map(|g| g.max(0.0)).norm()
            }
            _ => 0.0,
        }
    }
}

/// World states, one leading to the next, the current one last; where everything is in each is worked out when it is asked for.
#[derive(Debug)]
pub(in crate::grp) struct States {
    all: Vec<State>,
    layouts: Vec<Option<Arc<Layout>>>,
}

impl std::ops::Deref for States {
    type Target = [State];

    fn deref(&self) -> &[State] {
        &self.all
    }
}

impl States {
    pub(in crate::grp) fn new(start: State) -> States {
        States {
            all: vec![start],
            layouts: vec![None],
        }
    }

    pub(in crate::grp) fn push(&mut self, state: State) {
        self.all.push(state);
        self.layouts.push(None);
    }

    pub(in crate::grp) fn truncate(&mut self, n: usize) {
        self.all.truncate(n);
        self.layouts.truncate(n);
    }

    /// Returns where everything is in the current state; `None` where there is no state.
    pub(super) fn layout(&mut self, scene: &Scene, prepared: &Prepared, items: &mut Items) -> Option<Arc<Layout>> {
        let (last, earlier) = self.layouts.split_last_mut()?;
        if let Some(known) = last {
            return Some(Arc::clone(known));
        }
        let state = self.all.last()?;
        // The nearest state before it, of which most is still true.
        let before = earlier
            .iter()
            .zip(&self.all)
            .rev()
            .find_map(|(l, s)| Some((s, l.as_deref()?)));
        let layout = Arc::new(items.layout(scene, prepared, state, before));
        *last = Some(Arc::clone(&layout));
        Some(layout)
    }
}
