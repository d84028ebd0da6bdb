//! sphere-shadows beside shadows by exponentiation of spherical harmonics (Ren et al. 2006), from the same spheres, on
//! the plane and under the lights of the example `ladder`: the table of docs/notes/SPHERE-SHADOWS.md. It takes some
//! minutes, and bunny-shadow needs the assets (`make assets`):
//!
//! `cargo run --release --example exponentiation -- bunny-shadow|knot-twist`

#[path = "../ladder/plane.rs"]
mod plane;

use glam::Vec3;
use plane::{Lit, Prepared, SPHERES, blocked_by_mesh, flip, percent, prepared};
use rayon::prelude::*;
use relume_bake::error::{BakeError, Result};
use relume_bake::methods::sphere_shadows::errors::{Posed, lobes};
use relume_chart::harmonics::exponentiation::Exponentiation;
use relume_chart::harmonics::{Coefficients, of_texels, project};
use relume_formats::Place;
use relume_formats::basis::cap::{Bitmap, ROWS};
use relume_formats::basis::two_level::SIDE;
use relume_formats::evaluate::sphere_shadows::{Function, Levels, light};
use relume_formats::fast::sphere_shadows::{Shading, bitmaps};
use relume_formats::state::Rgb;
use std::process::ExitCode;
use std::time::Instant;

/// Terms of light and lobes, which the source of sphere-shadows has at most.
const TERMS: Option<usize> = Some(200);
/// Rounds that the best time is taken of.
const ROUNDS: usize = 5;

/// What all numbers of spheres have in common.
struct Plane<'a> {
    prepared: &'a Prepared,
    lights: &'a [Lit],
    /// The lobe of all receivers, by texels.
    rho: Vec<f32>,
    lobes: Vec<Function>,
    texels: Vec<(Coefficients, f32)>,
    exponentiation: Exponentiation,
}

/// Images under all lights, and microseconds that a receiver takes on one thread where that is measured.
struct Row {
    name: &'static str,
    images: Vec<Vec<Rgb>>,
    time_us: Option<f64>,
}

impl Plane<'_> {
    fn by_texels(&self, blocked: &[Bitmap]) -> Vec<Vec<Rgb>> {
        let image = |lit: &Lit| blocked.par_iter().map(|b| lit.sum(&self.rho, b)).collect();
        self.lights.iter().map(image).collect()
    }

    /// The product of light and lobe, projected.
    fn reflected(&self, lit: &Lit) -> [Coefficients; 3] {
        std::array::from_fn(|c| {
            let integrals = lit.texels[c].iter().zip(&self.rho).map(|(light, rho)| light * rho);
            project(&integrals.collect::<Vec<f32>>(), &self.texels)
        })
    }

    fn by_harmonics(&self, open: &[Coefficients]) -> Vec<Vec<Rgb>> {
        self.lights.iter().map(|lit| shaded(&self.reflected(lit), open)).collect()
    }

    fn projected(&self, blocked: &Bitmap) -> Coefficients {
        let open = |texel: usize| blocked[texel / SIDE] >> (texel % SIDE) & 1 == 0;
        let seen = self.texels.iter().enumerate().map(|(at, (_, angle))| if open(at) { *angle } else { 0.0 });
        project(&seen.collect::<Vec<f32>>(), &self.texels)
    }

    /// All rows of a number of spheres; the first is what the spheres block, exactly.
    fn rows(&self, number: usize) -> Result<Vec<Row>> {
        let posed = self.prepared.posed(number, &self.prepared.plane)?;
        let exact = bitmaps(&posed.receivers, &posed.casters);
        let positions: Vec<Vec3> = posed.receivers.iter().map(|receiver| receiver.position).collect();
        let spheres = &posed.casters.spheres[0].now;
        let untimed = |name, images| Row { name, images, time_us: None };
        let logarithms = self.exponentiation.logarithms(&positions, spheres);
        let series: Vec<Coefficients> =
            logarithms.par_iter().map(|log| self.exponentiation.series(log)).collect();
        let projected: Vec<Coefficients> = exact.par_iter().map(|blocked| self.projected(blocked)).collect();
        let reflected = self.lights.iter().map(|lit| self.reflected(lit)).collect::<Vec<_>>();
        let hybrid = |reflected: &[Coefficients; 3]| {
            timed(positions.len(), || shaded(reflected, &self.exponentiation.open(&positions, spheres)))
        };
        let (hybrid, times): (Vec<_>, Vec<f64>) =
            reflected.iter().map(hybrid).collect::<Result<Vec<_>>>()?.into_iter().unzip();
        Ok(vec![
            untimed("spheres, exactly", self.by_texels(&exact)),
            self.ours(&posed)?,
            untimed("what spheres leave open, projected to 25 functions", self.by_harmonics(&projected)),
            untimed("exponentiation by its series", self.by_harmonics(&series)),
            Row {
                name: "exponentiation by the source's hybrid",
                images: hybrid,
                time_us: times.first().copied(),
            },
        ])
    }

    fn ours(&self, posed: &Posed) -> Result<Row> {
        let image = |lit: &Lit| {
            let shading = Shading::new(&self.lobes, &light(lit.planes.clone(), TERMS), Levels::Two);
            timed(posed.receivers.len(), || posed.under(&shading))
        };
        let (images, times): (Vec<_>, Vec<f64>) =
            self.lights.iter().map(image).collect::<Result<Vec<_>>>()?.into_iter().unzip();
        Ok(Row { name: "sphere-shadows, 200 terms, level II", images, time_us: times.first().copied() })
    }
}

/// Radiances of receivers that reflect so much, where so much is open.
fn shaded(reflected: &[Coefficients; 3], open: &[Coefficients]) -> Vec<Rgb> {
    let of = |open: &Coefficients| {
        reflected.each_ref().map(|reflected| reflected.iter().zip(open).map(|(r, o)| r * o).sum())
    };
    open.iter().map(of).collect()
}

/// What `of` gives, and the microseconds of one thread that it takes for each of `count`.
fn timed<T: Send>(count: usize, of: impl Fn() -> T + Send + Sync) -> Result<(T, f64)> {
    let failed = |e: rayon::ThreadPoolBuildError| BakeError::invalid(&Place::file("threads"), e.to_string());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(failed)?;
    pool.install(|| {
        let (mut found, mut best) = (of(), f64::INFINITY);
        for _ in 0..ROUNDS {
            let start = Instant::now();
            found = of();
            best = best.min(start.elapsed().as_secs_f64());
        }
        Ok((found, best * 1e6 / count as f64))
    })
}

fn print(prepared: &Prepared, lights: &[Lit]) -> Result<()> {
    let rho = prepared.rho(&prepared.posed(0, &prepared.plane)?.receivers[0]);
    let by_mesh = blocked_by_mesh(&prepared.scene, &prepared.plane, |_| rho.clone());
    let plane = Plane {
        prepared,
        lights,
        rho,
        lobes: lobes(&prepared.shadows, TERMS),
        texels: of_texels(SIDE),
        exponentiation: Exponentiation::default(),
    };
    let truth = plane.by_texels(&by_mesh);
    let all = (0..SPHERES.len()).map(|number| plane.rows(number)).collect::<Result<Vec<Vec<Row>>>>()?;
    let line = |row: usize, cell: &dyn Fn(&[Row]) -> String| {
        println!(
            "| {} | {} |",
            all[0][row].name,
            all.iter().map(|rows| cell(rows)).collect::<Vec<_>>().join(" | ")
        );
    };
    let heading = |of: &str| {
        println!(
            "\n**{}, {of}**\n\n| | {} |\n|---|---|---|---|---|",
            prepared.title,
            SPHERES.map(|n| format!("n_s = {n}")).join(" | ")
        );
    };
    for (at, lit) in lights.iter().enumerate() {
        heading(&format!("{}: relative L2 in %, FLIP, to rays and the mesh / to the spheres", lit.name));
        let open = lit.sum(&plane.rho, &[0; ROWS]);
        for row in 0..all[0].len() {
            line(row, &|rows: &[Row]| {
                let (ours, exact) = (&rows[row].images[at], &rows[0].images[at]);
                let [l2, l2_exact] = [&truth[at], exact].map(|reference| percent(ours, reference));
                let [flip, flip_exact] = [&truth[at], exact].map(|reference| flip(ours, reference, open));
                format!("{l2:.2}, {flip:.4} / {l2_exact:.2}, {flip_exact:.4}")
            });
        }
    }
    heading("µs a receiver on one thread");
    for row in (0..all[0].len()).filter(|row| all[0][*row].time_us.is_some()) {
        line(row, &|rows: &[Row]| rows[row].time_us.map_or_else(String::new, |time| format!("{time:.2}")));
    }
    Ok(())
}

fn main() -> ExitCode {
    let printed =
        prepared(std::env::args().nth(1).as_deref()).and_then(|(prepared, lights)| print(&prepared, &lights));
    let Err(error) = printed else { return ExitCode::SUCCESS };
    eprintln!("error: {error}");
    ExitCode::from(error.exit_code())
}
