use glam::DVec3;
use relume_bake::spheres::{ball::Ball, triangle_tree::TriangleTree};
fn main() {
    let text = std::fs::read_to_string(std::env::args().nth(1).unwrap()).unwrap();
    let (mut v, mut f) = (Vec::new(), Vec::new());
    for l in text.lines() {
        let w: Vec<&str> = l.split_whitespace().collect();
        if w.first() == Some(&"v") {
            v.push(DVec3::new(w[1].parse().unwrap(), w[2].parse().unwrap(), w[3].parse().unwrap()));
        }
        if w.first() == Some(&"f") {
            let i = |k: usize| w[k].split('/').next().unwrap().parse::<u32>().unwrap() - 1;
            f.push([i(1), i(2), i(3)]);
        }
    }
    let mesh = TriangleTree::new(v, f);
    let mut state = 7_u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut wrong = 0;
    for _ in 0..3000 {
        let c = DVec3::new(random(), random(), random()) * 2.0 - 1.0;
        let mut near: Vec<f64> = mesh.vertices.iter().map(|v| v.distance_squared(c)).collect();
        near.sort_by(f64::total_cmp);
        let b = Ball::new(c, near[(random() * 40.0) as usize].sqrt());
        let o = b.outside(&mesh);
        let mut hits = 0;
        let mut k = 0;
        while k < 2000 {
            let p = DVec3::new(random(), random(), random()) * 2.0 - 1.0;
            if p.length_squared() <= 1.0 {
                k += 1;
                if !mesh.encloses(b.centre + p * b.radius) {
                    hits += 1;
                }
            }
        }
        let e = 1e-6;
        let fd =
            (Ball::new(b.centre, b.radius + e).outside(&mesh).volume - Ball::new(b.centre, b.radius - e).outside(&mesh).volume) / 2.0 / e;
        let share = hits as f64 / 2000.0;
        if (share - o.volume / b.volume()).abs() > 0.06 {
            wrong += 1;
            if wrong < 12 {
                println!(
                    "{b:?} sampled {share} exact {} area share {} fd {}",
                    o.volume / b.volume(),
                    o.area / b.radius.powi(2) / 12.566370614,
                    fd / b.radius.powi(2) / 12.566370614
                );
            }
        }
    }
    println!("wrong {wrong} of 3000");
}
