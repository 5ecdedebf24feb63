//! explore
use sgap::source::{Files, Sources};
use sgap::world::{self,*};
use sgap::geom::{*, ik, kinematics::Chain};
use rand::SeedableRng;
struct Disk;
impl Files for Disk { fn read(&self, path: &str) -> Result<String, String> { std::fs::read_to_string(path).map_err(|e| e.to_string()) } }
fn reach(w: &World, st: &State, agent: usize, arm: usize, X_WT: &Pose, point: bool, skip: &dyn Fn(&Contact)->bool, trace: bool) -> bool {
    let a = &w.scene.agents[agent]; let arm = &a.arms[arm];
    let X_WL = a.tree.link_poses(&st.agents[agent].X_WB, &st.agents[agent].q);
    let X_KT = X_WL[arm.base_link].inverse() * X_WT;
    let chain = Chain::new(&a.tree, arm.base_link, arm.tip_link, &arm.X_LT).unwrap();
    let seed: Vec<f64> = arm.dofs.iter().map(|d| st.agents[agent].q[*d]).collect();
    let settings = ik::Settings { max_iterations: 60, restarts: 15, position_tolerance: 1e-3, rotation_tolerance: 1e-2 };
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let target = if point { ik::Target::Point(X_KT.translation.vector) } else { ik::Target::Pose(X_KT) };
    let mut last = String::new();
    let r = ik::solve(&chain, &target, &seed, &settings, &mut rng, &mut |q| {
        let mut s = st.clone();
        for (d, v) in arm.dofs.iter().zip(q) { s.agents[agent].q[*d] = *v; }
        let c: Vec<Contact> = contacts(&w.scene, &s, 1e-3).into_iter().filter(|c| !skip(c)).collect();
        if let Some(c) = c.first() { last = format!("{} {} / {} {}", w.scene.id(c.a.entity), c.a.part, w.scene.id(c.b.entity), c.b.part); }
        c.is_empty()
    });
    if trace { match &r { Ok(_) => println!("   ok"), Err(e) => println!("   {e:?} {last}") } }
    r.is_ok()
}
#[test]
fn explore() {
  for path in ["worlds/three_objects.toml", "worlds/ramification.toml"] {
    println!("=== {path}");
    let mut sources = Sources::default();
    let (w, p) = world::load(path, &mut sources, &Disk);
    println!("{}", sgap::diag::render::render(&p, &sources, false));
    let Some(w) = w else { continue };
    let st = &w.start;
    for (o, obj) in w.scene.objects.iter().enumerate().filter(|(_, o)| o.movable) {
        println!("{}", obj.id);
        for g in &obj.grasps { for arm in 0..2 {
            let X = st.objects[o].X_WO * g.X_OT;
            let skip = |c: &Contact| c.b.entity == EntityRef::Object(o) && c.a.part.contains("gripper");
            let up = Pose::translation(0.,0.,0.);
            let ok = reach(&w, st, 0, arm, &(up*X), false, &skip, false);
            let pre = X * Pose::translation(-0.1,0.,0.);
            let ok2 = ok && reach(&w, st, 0, arm, &pre, false, &|_| false, false);
            println!("  {} {} {} pre {}", w.scene.agents[0].arms[arm].name, g.name, ok, ok2);
        } }
        for arm in 0..2 { println!("  BOB reach {}", reach(&w, st, 1, arm, &st.objects[o].X_WO, true, &|_| true, false)); }
    }
    // shared area: cube 3 cm above table
    let sup = &w.scene.objects[0].supports[0];
    let X_WF = st.objects[0].X_WO * sup.X_OF;
    for iy in (-7..=7).rev() { let mut line = String::new(); for ix in -5..=5 {
        let (x, y) = (ix as f64 * 0.075, iy as f64 * 0.09);
        if x.abs() > sup.half[0]-0.03 || y.abs() > sup.half[1]-0.03 { line += "   "; continue; }
        let p = X_WF * nalgebra::Point3::new(x, y, 0.04);
        let down = pose_xyz_rpy([p.x, p.y, p.z], [0., std::f64::consts::FRAC_PI_2, 0.]);
        let r = reach(&w, st, 0, 0, &down, false, &|_| false, false); let l = reach(&w, st, 0, 1, &down, false, &|_| false, false);
        let h = (0..2).any(|arm| reach(&w, st, 1, arm, &Pose::translation(p.x, p.y, p.z+0.03), true, &|_| false, false));
        line += match (r, l, h) { (true,true,true)=>" B*", (true,false,true)=>" R*", (false,true,true)=>" L*", (true,true,false)=>" B.", (true,false,false)=>" R.", (false,true,false)=>" L.", (false,false,true)=>" h ", _=>" - " };
    } println!("{y:6.2} {line}", y = iy as f64*0.09); }
  }
}
