use glam::DVec3;
use relume_bake::spheres::{cluster::*, pieces::*, search::*, start::start, triangle_tree::TriangleTree};
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let w: Vec<&str> = s.split_whitespace().collect();
    (w[13].parse::<f64>().unwrap() + w[14].parse::<f64>().unwrap()) / 100.0
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&args[1]).unwrap();
    let n: usize = args[2].parse().unwrap();
    let seconds: f64 = args[3].parse().unwrap();
    let seed: u64 = args.get(4).map_or(1, |s| s.parse().unwrap());
    let (mut v, mut f) = (Vec::new(), Vec::new());
    if text.starts_with("OFF") {
        let mut it = text.split_whitespace().skip(1);
        let nv: usize = it.next().unwrap().parse().unwrap();
        let nf: usize = it.next().unwrap().parse().unwrap();
        it.next();
        for _ in 0..nv {
            let mut g = || it.next().unwrap().parse::<f64>().unwrap();
            v.push(DVec3::new(g(), g(), g()));
        }
        for _ in 0..nf {
            it.next();
            let mut g = || it.next().unwrap().parse::<u32>().unwrap();
            f.push([g(), g(), g()]);
        }
    } else {
        for l in text.lines() {
            let w: Vec<&str> = l.split_whitespace().collect();
            if w.first() == Some(&"v") {
                v.push(DVec3::new(w[1].parse().unwrap(), w[2].parse().unwrap(), w[3].parse().unwrap()));
            }
            if w.first() == Some(&"f") {
                let i = |k: usize| w[k].split('/').next().unwrap().parse::<u32>().unwrap() - 1;
                for k in 2..w.len() - 1 {
                    f.push([i(1), i(k), i(k + 1)]);
                }
            }
        }
    }
    let mesh = TriangleTree::new(v.clone(), f.clone());
    let root = &mesh.nodes[0];
    let volume = root.moment / 3.0;
    let area: f64 = (0..f.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(c - a).length() / 2.0
        })
        .sum();
    let target: f64 = args.get(5).map_or(150.0 * n as f64, |s| s.parse().unwrap());
    let h = (area / target.max(2000.0) * 2.0).sqrt() * 1.6;
    let diag = (root.max - root.min).length();
    let mut pieces = Pieces::new(&mesh, h);
    let surface = pieces.len();

    let g = (volume / (15.0 * n as f64).max(500.0)).cbrt();
    let e = (root.max - root.min) / g;
    for i in 0..e.x as i64 + 1 {
        for j in 0..e.y as i64 + 1 {
            for k in 0..e.z as i64 + 1 {
                let p = root.min + DVec3::new(i as f64 + 0.5, j as f64 + 0.5, k as f64 + 0.5) * g;
                if mesh.encloses(p) && std::env::var("NOIN").is_err() {
                    pieces.add_inside(&[p]);
                }
            }
        }
    }
    println!("faces {} pieces {surface} all {} volume {volume:.4} h {h:.4}", f.len(), pieces.len());
    let problem = Problem { solid: &mesh, pieces, slack: 0.0 };
    let s = start(&problem, n, seed);
    let rounds: u64 = args.get(6).map_or(120, |s| s.parse().unwrap());
    let heat: f64 = args.get(7).map_or(0.5, |s| s.parse().unwrap());
    let mut search = Search::new(problem, s, seed);
    println!("start {:.4} {:.2}s", search.lowest() / volume, cpu());
    let last = 0.003 * diag;
    let every: u64 = args.get(8).map_or(8, |s| s.parse().unwrap());
    for r in 0..rounds {
        let f = r as f64 / rounds as f64;
        if r > 0 && r % every == 0 {
            search.refine(h * (last / h).powf(f));
        }
        let t = (1.0 - f / 0.75).max(0.0);
        search.round(heat * t * t);
        if r % 20 == 19 {
            println!(
                "  {r} pieces {} {:.4} {:.2}s",
                search.best().iter().map(|s| s.cluster.len()).sum::<usize>(),
                search.lowest() / volume,
                cpu()
            );
        }
    }
    search.refine(last);
    search.refine(last);
    let spheres = search.best().to_vec();
    let balls: Vec<_> = spheres.iter().map(|s| relume_bake::spheres::ball::Ball::new(s.ball.centre, s.ball.radius + 1e-9 * diag)).collect();
    let a = relume_bake::spheres::coverage::uncovered_on_surface(&mesh, &balls);
    let b = relume_bake::spheres::coverage::uncovered_within(&mesh, &balls);
    println!("uncovered {} {} {:.2}s min radius {:.4}", a.len(), b.len(), cpu(), spheres.iter().map(|s| s.ball.radius).fold(9.0, f64::min));
    for p in &a {
        let g = balls.iter().map(|b| p.distance(b.centre) - b.radius).fold(9.0, f64::min);
        println!("gap {g:e} at {p}");
    }
    let mut s2 = 7_u64;
    let mut rnd = move || {
        s2 = s2.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (s2 >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut sorted: Vec<&Sphere> = spheres.iter().collect();
    sorted.sort_by(|a, b| b.outside.volume.total_cmp(&a.outside.volume));
    for s in sorted {
        print!("{:.4}/{:.2}/{} ", s.outside.volume / volume, s.ball.radius, s.cluster.len());
    }
    println!();
    let (mut a, mut b) = (0.0, 0.0);
    for s in spheres.iter() {
        let pos = search.problem.pieces.positions(&s.cluster);
        let base = search.problem.sphere(s.ball.centre, s.cluster.clone(), &pos);
        let refit = search.problem.refit(&base, 100);
        let mut best = refit.clone();
        let mut width = 0.1 * base.ball.radius;
        for k in 0..2000 {
            if k % 200 == 199 {
                width *= 0.5;
            }
            let d = DVec3::new(rnd() - 0.5, rnd() - 0.5, rnd() - 0.5) * 2.0 * width;
            let t = search.problem.sphere(best.ball.centre + d, s.cluster.clone(), &pos);
            if t.outside.volume < best.outside.volume {
                best = t;
            }
        }
        a += refit.outside.volume;
        b += best.outside.volume;
    }
    println!("clusters: kept {:.4} refit {:.4} random search {:.4}", total_outside(&spheres) / volume, a / volume, b / volume);
    let mut state = 7_u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut total = 0.0;
    for s in &spheres {
        let mut hits = 0;
        let mut k = 0;
        while k < 3000 {
            let p = DVec3::new(random(), random(), random()) * 2.0 - 1.0;
            if p.length_squared() <= 1.0 {
                k += 1;
                if !mesh.encloses(s.ball.centre + p * s.ball.radius) {
                    hits += 1;
                }
            }
        }
        let share = hits as f64 / 3000.0;
        let exact = s.outside.volume / s.ball.volume();
        if (share - exact).abs() > 0.05 {
            println!("WRONG {:?} {share} {exact}", s.ball);
        }
        total += share * s.ball.volume();
    }
    println!("sampled {:.4}", total / volume);
}
