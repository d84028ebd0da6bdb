//! Highlights in the shader against those of the CPU.

use crate::gpu::Gpu;
use crate::lit::gpu_data::Material;
use crate::testing::{gpu, read_values};
use glam::Vec3;
use relume_formats::basis::Angles;
use relume_formats::basis::microfacet::{Facets, schlick};
use relume_formats::state::{BlinnPhong, Brdf, CookTorrance, Ggx};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use wgpu::BufferUsages;

/// What the shader makes of materials and pairs of directions about +Z.
const PROBE: &str = "
#import brdf

struct Case {
    incoming: vec3<f32>,
    material: u32,
    outgoing: vec3<f32>,
}

@group(0) @binding(0) var<storage, read> materials: array<Material>;
@group(0) @binding(1) var<storage, read> cases: array<Case>;
// Glossy, and the diffuse part's share.
@group(0) @binding(2) var<storage, read_write> values: array<vec4<f32>>;

@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x < arrayLength(&cases) {
        let each = cases[invocation.x];
        let angles = angles_between(each.incoming, each.outgoing, vec3<f32>(0.0, 0.0, 1.0));
        let material = materials[each.material];
        values[invocation.x] = vec4<f32>(glossy_lobe(material, angles), diffuse_lobe(material, angles));
    }
}
";

#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Case {
    incoming: [f32; 3],
    material: u32,
    outgoing: [f32; 3],
    unused: u32,
}

impl Case {
    fn new(incoming: Vec3, material: u32, outgoing: Vec3) -> Self {
        Self { incoming: incoming.to_array(), material, outgoing: outgoing.to_array(), unused: 0 }
    }
}

/// By case the glossy lobe, and what multiplies the diffuse one.
fn probe(gpu: &Gpu, brdfs: &[Brdf], cases: &[Case]) -> Vec<[f32; 4]> {
    let material = |brdf: &Brdf| {
        let mut material: Material = bytemuck::Zeroable::zeroed();
        material.set_brdf(brdf);
        material
    };
    let materials = gpu.storage("materials", &brdfs.iter().map(material).collect::<Vec<_>>());
    let cases_there = gpu.storage("cases", cases);
    let bytes = (cases.len() * size_of::<[f32; 4]>()) as u64;
    let values = gpu.buffer("values", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
    let pipeline = gpu.compute_pipeline(PROBE, "probe");
    let bound = [&materials, &cases_there, &values].map(wgpu::Buffer::as_entire_binding);
    let bindings = gpu.bind(&pipeline.get_bind_group_layout(0), bound);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &bindings, &[]);
    pass.dispatch_workgroups((cases.len() as u32).div_ceil(64), 1, 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    read_values(gpu, &values)
}

/// The same by the CPU: the BRDFs of `relume_formats::state` without their diffuse parts.
fn on_cpu(brdf: &Brdf, case: &Case) -> [f32; 4] {
    let [incoming, outgoing] = [case.incoming, case.outgoing].map(Vec3::from);
    let half = (incoming + outgoing).normalize_or_zero();
    let angles = Angles {
        cos_half: half.z.clamp(0.0, 1.0),
        cos_difference: half.dot(outgoing).clamp(0.0, 1.0),
        cos_in: incoming.z.max(0.0),
        cos_out: outgoing.z.max(0.0),
    };
    let weight = schlick(angles.cos_difference);
    let fresnel = |f0: f32| f0 + (1.0 - f0) * weight;
    let ([r, g, b], diffuse) = match brdf {
        Brdf::BlinnPhong(BlinnPhong { ks, shininess, .. }) => {
            let lobe = (shininess + 2.0) / TAU * angles.cos_half.powf(*shininess);
            (ks.map(|ks| ks * lobe), 1.0)
        }
        Brdf::Ggx(ggx) => {
            let lobe = Facets::Ggx.lobe(ggx.roughness, &angles);
            (ggx.f0().map(|f0| fresnel(f0) * lobe), 1.0 - weight)
        }
        Brdf::CookTorrance(CookTorrance { ks, fresnel: f0, roughness, .. }) => {
            let lobe = fresnel(*f0) * Facets::CookTorrance.lobe(*roughness, &angles);
            (ks.map(|ks| ks * lobe), 1.0)
        }
    };
    [r, g, b, diffuse]
}

fn blinn_phong(shininess: f32) -> Brdf {
    Brdf::BlinnPhong(BlinnPhong { kd: [0.1, 0.2, 0.3], ks: [0.7, 0.5, 0.0], shininess })
}

fn ggx(metallic: f32, roughness: f32) -> Brdf {
    Brdf::Ggx(Ggx { base_color: [0.9, 0.5, 0.1], metallic, roughness })
}

fn cook_torrance(fresnel: f32, roughness: f32) -> Brdf {
    Brdf::CookTorrance(CookTorrance { kd: [0.3, 0.2, 0.1], ks: [0.7, 0.5, 0.9], fresnel, roughness })
}

/// The square of a lobe's width about the half vector, radians².
fn width_squared(brdf: &Brdf) -> f32 {
    match brdf {
        Brdf::BlinnPhong(brdf) => 1.0 / brdf.shininess,
        Brdf::Ggx(brdf) => brdf.roughness.powi(4),
        Brdf::CookTorrance(brdf) => brdf.roughness.powi(2),
    }
}

fn direction(theta: f32, phi: f32) -> Vec3 {
    let ((sin, cos), (sin_phi, cos_phi)) = (theta.sin_cos(), phi.sin_cos());
    Vec3::new(sin * cos_phi, sin * sin_phi, cos)
}

#[test]
fn lobes_are_the_cpus_at_any_angle() {
    let Some(gpu) = gpu() else { return };
    let brdfs = [
        blinn_phong(1.0),
        blinn_phong(37.5),
        blinn_phong(200.0),
        blinn_phong(1e4),
        ggx(0.0, 0.32),
        ggx(0.4, 0.7),
        ggx(1.0, 1.0),
        ggx(1.0, 0.12),
        cook_torrance(0.0, 0.1),
        cook_torrance(0.5, 0.35),
        cook_torrance(1.0, 1.0),
        cook_torrance(0.8, 0.015),
    ];
    // Evenly scattered over angles, every third about the mirror direction, and the ends of all ranges.
    let scattered = (0..6000).map(|k| {
        let share = |step: f32| (k as f32 * step).fract();
        let outgoing = direction(FRAC_PI_2 * share(0.618_034), TAU * share(0.754_878));
        let incoming = direction(FRAC_PI_2 * share(0.569_84), TAU * share(0.412_454_7));
        let mirror = outgoing * Vec3::new(-1.0, -1.0, 1.0);
        (if k % 3 == 0 { (mirror + 0.1 * incoming).normalize() } else { incoming }, outgoing)
    });
    let (low, flat) = (direction(FRAC_PI_2 - 1e-4, 0.3), Vec3::X);
    let ends =
        [(Vec3::Z, Vec3::Z), (low, Vec3::Z), (low, low), (flat, flat), (flat, -flat), (-Vec3::Z, Vec3::Z)];
    let ends =
        ends.into_iter().chain([(direction(FRAC_PI_2 - 1e-4, 0.3 + PI), low), (flat, low), (Vec3::Z, flat)]);
    let cases: Vec<Case> = scattered
        .chain(ends)
        .flat_map(|(incoming, outgoing)| {
            (0..brdfs.len() as u32).map(move |material| Case::new(incoming, material, outgoing))
        })
        .collect();
    for (ours, case) in probe(&gpu, &brdfs, &cases).into_iter().zip(&cases) {
        let brdf = &brdfs[case.material as usize];
        let theirs = on_cpu(brdf, case);
        // A few roundings of cosines near 1 and of the logarithm that makes a power, each of some 1e-7 and
        // divided by the square of the width; what is at right angles to the normal is what rounding says.
        let bound = 2e-5 + 1e-6 / width_squared(brdf);
        let grazing = case.incoming[2].min(case.outgoing[2]) < 1e-3;
        for (ours, theirs) in ours.into_iter().zip(theirs) {
            assert!(ours.is_finite() && ours >= 0.0, "{brdf:?} {case:?}: {ours}");
            let most = if grazing { 10.0 * bound } else { bound };
            assert!((ours - theirs).abs() <= most * theirs + 1e-6, "{brdf:?} {case:?}: {ours}, not {theirs}");
        }
    }
}

/// What of even light a unit lobe reflects in a direction: as much as by the CPU, of microfacets never more
/// than arrives, and of Blinn-Phong seen from above what the closed form says.
#[test]
fn no_energy_comes_out_of_grazing_angles() {
    let Some(gpu) = gpu() else { return };
    let brdfs = [
        Brdf::BlinnPhong(BlinnPhong { kd: [0.0; 3], ks: [1.0; 3], shininess: 200.0 }),
        Brdf::Ggx(Ggx { base_color: [1.0; 3], metallic: 1.0, roughness: 0.32 }),
        Brdf::Ggx(Ggx { base_color: [1.0; 3], metallic: 1.0, roughness: 1.0 }),
        Brdf::CookTorrance(CookTorrance { kd: [0.0; 3], ks: [1.0; 3], fresnel: 1.0, roughness: 0.1 }),
        Brdf::CookTorrance(CookTorrance { kd: [0.0; 3], ks: [1.0; 3], fresnel: 1.0, roughness: 0.6 }),
    ];
    let (rows, columns) = (360, 360);
    for theta_deg in [0.0_f32, 45.0, 75.0, 85.0, 89.0, 89.99] {
        let outgoing = direction(theta_deg.to_radians(), 0.0);
        for (material, brdf) in brdfs.iter().enumerate() {
            let angles = |k: usize| {
                let part = |index: usize, count: usize| (index as f32 + 0.5) / count as f32;
                (FRAC_PI_2 * part(k / columns, rows), TAU * part(k % columns, columns))
            };
            let cases: Vec<Case> = (0..rows * columns)
                .map(|k| Case::new(direction(angles(k).0, angles(k).1), material as u32, outgoing))
                .collect();
            // Of a step of θ and φ.
            let area = FRAC_PI_2 * TAU / (rows * columns) as f32;
            let weight = |k: usize| f64::from(area * angles(k).0.sin() * angles(k).0.cos());
            let sum = |values: &mut dyn Iterator<Item = f32>| -> f64 {
                values.enumerate().map(|(k, value)| f64::from(value) * weight(k)).sum()
            };
            let ours = sum(&mut probe(&gpu, &brdfs, &cases).into_iter().map(|value| value[0]));
            let theirs = sum(&mut cases.iter().map(|case| on_cpu(brdf, case)[0]));
            let what = format!("{brdf:?} towards {theta_deg}°: {ours}, on the CPU {theirs}");
            assert!((ours - theirs).abs() <= 1e-4 * theirs, "{what}");
            let exact = match brdf {
                Brdf::BlinnPhong(brdf) if theta_deg == 0.0 => albedo_from_above(brdf.shininess),
                Brdf::BlinnPhong(_) => continue,
                _ => {
                    // The sum over steps of a quarter of a degree is right to a hundredth.
                    assert!(ours > 0.3 && ours < 1.01, "{what}");
                    continue;
                }
            };
            assert!((ours - exact).abs() < 1e-3 * exact, "{what}, exactly {exact}");
        }
    }
}

/// 4(s + 2) ∫ uˢ⁺¹ (2u² − 1) du from √½ to 1, with u the cosine to the half vector.
fn albedo_from_above(shininess: f32) -> f64 {
    let s = f64::from(shininess);
    let power_integral = |n: f64| (1.0 - 0.5f64.powf(n / 2.0)) / n;
    4.0 * (s + 2.0) * (2.0 * power_integral(s + 4.0) - power_integral(s + 2.0))
}
