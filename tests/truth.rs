//! The tracer against closed forms.

use crate::support::{mean_radiance, render, scene};
use glam::Vec3A;
use relume_bake::brdf::blinn_phong::glossy_albedo;
use relume_bake::trace::reference::Paths;
use relume_formats::state::{BlinnPhong, Brdf, CookTorrance, Ggx};
use relume_scenes::{Cone, Emitter, Filter, Glow, Light, Material, Mesh, Object, Scene, Texture, Wrap};
use std::f64::consts::PI;
use std::sync::Arc;

fn v(x: f32, y: f32, z: f32) -> Vec3A {
    Vec3A::new(x, y, z)
}

/// One object of one material under a white sky.
fn under_white_sky(shape: &str, kd: f32, ks: f32, shininess: f32) -> String {
    format!(
        "[camera]\nposition = [0, 0.3, 4]\ntarget = [0, 0, 0]\nfov_deg = 30\n[render]\nsize = [24, 24]\n[environment]\ngain = [1, 1, 1]\n\
         [materials.m]\nbrdf = 'blinn-phong'\nkd = [{kd}, {kd}, {kd}]\nks = [{ks}, {ks}, {ks}]\nshininess = {shininess}\n\
         [[object]]\nname = 'o'\nmaterial = 'm'\nshape = '{shape}'\n"
    )
}

/// Everything white in a white sky looks as if it was not there.
#[test]
fn white_furnace() {
    // A box has its shading normals where its faces are; smooth ones lose or gain at the silhouette, which is
    // a known fault of all shading normals.
    let text = under_white_sky("box", 1.0, 0.0, 1.0);
    for paths in [Paths::Best, Paths::Gather] {
        let reflections = if paths == Paths::Best { 50 } else { 2 };
        let image = render(&scene(&text), [24, 24], 64, reflections, paths, 1);
        for (radiance, variance) in image.radiance.iter().flatten().zip(image.variance.iter().flatten()) {
            assert!(
                (radiance - 1.0).abs() < 6.0 * variance.sqrt() + 1e-4,
                "{paths:?}: {radiance} ± {}",
                variance.sqrt()
            );
        }
        let n = image.radiance.as_flattened().len() as f32;
        let mean = image.radiance.iter().flatten().sum::<f32>() / n;
        // Channels are alike, so a third of the values are independent.
        let error = image.variance.iter().flatten().sum::<f32>().sqrt() / n * 3.0f32.sqrt();
        assert!((mean - 1.0).abs() < 4.0 * error + 1e-4 && error < 0.003, "{paths:?}: mean {mean} ± {error}");
    }
    // Concave: two boxes that face each other across a slit, light going back and forth many times.
    let two = text.clone()
        + "transform = { translation = [-0.55, 0, 0] }\n[[object]]\nname = 'p'\nmaterial = 'm'\nshape = 'box'\ntransform = { translation = [0.55, 0, 0] }\n";
    let (mean, error) = mean_radiance(&scene(&two), 10_000, 20_000, |[x, y]| {
        (v(0.0, 0.0, 2.0), v(0.2 * (x - 0.5), 0.3 * (y - 0.5), -1.0).normalize())
    });
    assert!((mean - 1.0).abs() < 4.0 * error + 1e-3, "{mean} ± {error}");
}

/// The glossy lobe under a white sky reflects its albedo, which has a closed form straight from above.
#[test]
fn glossy_albedo_from_above() {
    for shininess in [1.0, 5.0, 50.0, 200.0] {
        let scene = scene(&under_white_sky("quad", 0.0, 0.5, shininess));
        let (mean, error) =
            mean_radiance(&scene, 1, 1 << 16, |[x, y]| (v(0.1 * x, 1.0, 0.1 * y), Vec3A::NEG_Y));
        let expected = 0.5 * f64::from(glossy_albedo(shininess));
        assert!(
            (mean - expected).abs() < 4.0 * error + 1e-4 * expected,
            "s = {shininess}: {mean} ± {error}, expected {expected}"
        );
    }
}

const LIT_FLOOR: &str = "
    [camera]
    position = [0.3, 0.5, 0.2]
    target = [0.3, 0.0, 0.2001]
    fov_deg = 0.1
    [render]
    size = [1, 1]
    [materials.m]
    brdf = 'blinn-phong'
    kd = [0.8, 0.8, 0.8]
    [[object]]
    name = 'floor'
    material = 'm'
    shape = 'quad'
    transform = { scale = 10.0 }
    [[light]]
    name = 'lamp'
    kind = 'area'
    radiance = [2.0, 2.0, 2.0]
    transform = { translation = [0.0, 1.0, 0.0], rotation_deg = [-90.0, 0.0, 0.0] }
";

/// Irradiance from a polygon of radiance 1 by Lambert's formula: ½ Σ angle of each edge × normal component of
/// its plane.
fn polygon_irradiance(point: [f64; 3], corners: &[[f64; 3]]) -> f64 {
    let unit = |c: &[f64; 3]| {
        let d = [c[0] - point[0], c[1] - point[1], c[2] - point[2]];
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        d.map(|x| x / length)
    };
    let edge = |(i, a): (usize, &[f64; 3])| {
        let (a, b) = (unit(a), unit(&corners[(i + 1) % corners.len()]));
        let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let sine = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
        let cosine = a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        sine.atan2(cosine) * cross[1] / sine
    };
    0.5 * corners.iter().enumerate().map(edge).sum::<f64>().abs()
}

/// A floor point under a square lamp, against Lambert's polygon formula, for both kinds of paths.
#[test]
fn area_light_irradiance() {
    let lamp = [[-0.5, 1.0, -0.5], [0.5, 1.0, -0.5], [0.5, 1.0, 0.5], [-0.5, 1.0, 0.5]];
    let expected = 0.8 / PI * 2.0 * polygon_irradiance([0.3, 0.0, 0.2], &lamp);
    for paths in [Paths::Best, Paths::Gather] {
        let image = render(&scene(LIT_FLOOR), [1, 1], 1 << 16, 1, paths, 3);
        let radiance = f64::from(image.radiance[0][0]);
        // The variance is an upper bound; stratification makes the true error smaller still. 1e-4 is the
        // spread of the footprint.
        let sigma = f64::from(image.variance[0][0]).sqrt();
        assert!(
            (radiance - expected).abs() < 4.0 * sigma + 1e-4 * expected && sigma < 0.01 * expected,
            "{radiance}, expected {expected} ± {sigma}"
        );
    }
}

/// Point and directional lights: inverse square and cosine by hand.
#[test]
fn point_and_directional_irradiance() {
    let without_lamp = LIT_FLOOR.split("[[light]]").next().unwrap();
    let point = "[[light]]\nname = 'p'\nkind = 'point'\nintensity = [3.0, 3.0, 3.0]\ntransform = { translation = [0.3, 2.0, 1.7] }\n";
    let sun = "[[light]]\nname = 's'\nkind = 'directional'\nirradiance = [5.0, 5.0, 5.0]\ntransform = { rotation_deg = [-30.0, 0.0, 0.0] }\n";
    // Light at height 2, 1.5 aside; the sun 30° above the horizon.
    let by_point = 3.0 * 2.0 / (2.0f64.powi(2) + 1.5f64.powi(2)).powf(1.5);
    let by_sun = 5.0 * 0.5;
    for (light, irradiance) in
        [(point.to_owned(), by_point), (sun.to_owned(), by_sun), (format!("{point}{sun}"), by_point + by_sun)]
    {
        let image = render(&scene(&format!("{without_lamp}{light}")), [1, 1], 1 << 14, 1, Paths::Gather, 3);
        let (radiance, expected) = (f64::from(image.radiance[0][0]), 0.8 / PI * irradiance);
        let sigma = f64::from(image.variance[0][0]).sqrt();
        assert!(
            (radiance - expected).abs() < 4.0 * sigma + 2e-4 * expected,
            "{radiance}, expected {expected} ± {sigma}"
        );
    }
}

/// A spot light has its full intensity within the inner cone, a ramp squared between the cones, and nothing
/// outside.
#[test]
fn spot_light_irradiance() {
    let mut scene = scene(LIT_FLOOR);
    for (cos_inner, cos_outer, share) in [(0.7, 0.5, 1.0), (1.0, 0.6, 0.25), (0.95, 0.9, 0.0)] {
        // 2 m above and 1.5 m aside of the point seen, pointing straight down: the cosine with the axis is
        // 0.8.
        let cone = Cone { direction: [0.0, -1.0, 0.0], cos_inner, cos_outer };
        scene.lights[0].emitter =
            Emitter::Point { position: [0.3, 2.0, 1.7], intensity: [3.0; 3], cone: Some(cone) };
        let expected = share * 0.8 / PI * 3.0 * 2.0 / (2.0f64.powi(2) + 1.5f64.powi(2)).powf(1.5);
        let image = render(&scene, [1, 1], 1 << 10, 1, Paths::Gather, 3);
        let radiance = f64::from(image.radiance[0][0]);
        // One light and a footprint of 0.9 mm: nothing is left to chance but the film sample. The ramp is
        // steep: 0.4 in the cosine.
        assert!(
            (radiance - expected).abs() < 2e-3 * expected + 1e-9,
            "cone {cos_inner} {cos_outer}: {radiance}, expected {expected}"
        );
    }
}

/// Makes `scene`, which has a lamp, lit by `mesh` instead, which is black but for what it emits.
fn lit_by(scene: &mut Scene, mesh: Mesh, glow: Option<Glow>) {
    let black = Brdf::BlinnPhong(BlinnPhong { kd: [0.0; 3], ks: [0.0; 3], shininess: 1.0 });
    scene.materials.push(Material { name: "black".to_owned(), brdf: black, ..scene.materials[0].clone() });
    let material = scene.materials.len() - 1;
    scene.objects.push(Object {
        name: "lamp".to_owned(),
        material,
        mesh: mesh.into(),
        ..scene.objects[0].clone()
    });
    scene.lights[0].emitter = Emitter::Mesh { object: scene.objects.len() - 1, radiance: [2.0; 3], glow };
}

/// A mesh that emits is the area light of its shape, however many triangles it has; with a texture only where
/// that glows.
#[test]
fn mesh_light_irradiance() {
    let lamp = [[-0.5, 1.0, -0.5], [0.5, 1.0, -0.5], [0.5, 1.0, 0.5], [-0.5, 1.0, 0.5]];
    let whole = 0.8 / PI * 2.0 * polygon_irradiance([0.3, 0.0, 0.2], &lamp);
    // A fan of four unequal triangles that faces down, and the texel of its texture that glows.
    let mut positions: Vec<[f32; 3]> = lamp.iter().map(|p| p.map(|x| x as f32)).collect();
    positions.push([0.2, 1.0, -0.3]);
    let triangles = (0..4).map(|i| [i, (i + 1) % 4, 4]).collect();
    let uvs: Vec<[f32; 2]> = positions.iter().map(|[x, _, z]| [x + 0.5, z + 0.5]).collect();
    let mesh = Mesh { normals: vec![[0.0, -1.0, 0.0]; 5], positions, uvs: Vec::new(), triangles };
    let mut texels = vec![[0, 0, 0, 255]; 20];
    texels[5 * 3 + 1] = [255; 4];
    let texture = Texture { size: [5, 4], wrap: [Wrap::Clamp; 2], filter: Filter::Nearest, texels };
    let texel = [[-0.3, 1.0, 0.25], [-0.1, 1.0, 0.25], [-0.1, 1.0, 0.5], [-0.3, 1.0, 0.5]];
    let part = 0.8 / PI * 2.0 * polygon_irradiance([0.3, 0.0, 0.2], &texel);
    for (glow, expected) in [(None, whole), (Some(Glow { texture: texture.into(), uvs: uvs.into() }), part)] {
        let mut scene = scene(LIT_FLOOR);
        lit_by(&mut scene, mesh.clone(), glow);
        for paths in [Paths::Best, Paths::Gather] {
            let image = render(&scene, [1, 1], 1 << 16, 1, paths, 3);
            let (radiance, sigma) = (f64::from(image.radiance[0][0]), f64::from(image.variance[0][0]).sqrt());
            assert!(
                (radiance - expected).abs() < 4.0 * sigma + 1e-4 * expected && sigma < 0.01 * expected,
                "{paths:?}: {radiance}, expected {expected} ± {sigma}"
            );
        }
    }
}

/// Inside a closed surface that reflects the share a and emits L, the radiance is L / (1 − a) everywhere;
/// after n reflections L (1 + a + … + aⁿ).
#[test]
fn a_surface_emits_and_reflects() {
    let text = under_white_sky("box", 0.6, 0.0, 1.0)
        .replace("[environment]\ngain = [1, 1, 1]\n", "")
        .replace("[0, 0.3, 4]", "[0.1, 0.2, 0.3]");
    let mut scene = scene(&text);
    let mesh = Arc::make_mut(&mut scene.objects[0].mesh);
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    mesh.normals.iter_mut().flatten().for_each(|x| *x = -*x);
    scene.lights.push(Light {
        name: "walls".to_owned(),
        emitter: Emitter::Mesh { object: 0, radiance: [2.0; 3], glow: None },
    });
    for (paths, reflections, expected) in [
        (Paths::Best, 0, 2.0),
        (Paths::Best, 1, 2.0 * 1.6),
        (Paths::Best, 1000, 2.0 / 0.4),
        (Paths::Gather, 1, 2.0 * 1.6),
        (Paths::Gather, 2, 2.0 * (1.0 + 0.6 + 0.36)),
    ] {
        let image = render(&scene, [12, 12], 256, reflections, paths, 1);
        let n = image.radiance.as_flattened().len() as f32;
        let mean = image.radiance.iter().flatten().sum::<f32>() / n;
        let error = image.variance.iter().flatten().sum::<f32>().sqrt() / n * 3.0f32.sqrt();
        assert!(
            (mean - expected).abs() < 4.0 * error + 1e-4 && error < 0.003 * expected,
            "{paths:?} {reflections}: {mean} ± {error}, expected {expected}"
        );
    }
    // The back emits nothing.
    let (outside, _) = mean_radiance(&scene, 4, 64, |[x, y]| (v(0.2 * x, 0.2 * y, 5.0), Vec3A::NEG_Z));
    assert_eq!(outside, 0.0);
}

/// Light through a sheet with holes: what arrives below is the share of holes, and shadow rays and paths
/// agree on them.
#[test]
fn holes_let_through_their_share_of_light() {
    let text = LIT_FLOOR.replace("[[light]]", "[materials.sheet]\nbrdf = 'blinn-phong'\nkd = [0, 0, 0]\n[[object]]\nname = 'sheet'\nmaterial = 'sheet'\nshape = 'quad'\ntransform = { translation = [0, 0.7, 0], scale = 3.0 }\n[[light]]");
    let mut scene = scene(&text);
    let expected = 0.8 / PI
        * 2.0
        * polygon_irradiance(
            [0.3, 0.0, 0.2],
            &[[-0.5, 1.0, -0.5], [0.5, 1.0, -0.5], [0.5, 1.0, 0.5], [-0.5, 1.0, 0.5]],
        );
    let sheet = scene.materials.iter().position(|m| m.name == "sheet").unwrap();
    // Fine stripes: one texel column in four is a hole. Interpolated alpha crosses one half midway between
    // texel centres.
    let texels = (0..4096).map(|i| [255, 255, 255, if i % 4 == 0 { 0 } else { 255 }]).collect();
    scene.materials[sheet].texture =
        Some(Texture { size: [4096, 1], wrap: [Wrap::Repeat; 2], filter: Filter::Linear, texels }.into());
    scene.materials[sheet].alpha_cutoff = Some(0.5);
    for paths in [Paths::Best, Paths::Gather] {
        let image = render(&scene, [1, 1], 1 << 16, 1, paths, 3);
        let (radiance, sigma) = (f64::from(image.radiance[0][0]), f64::from(image.variance[0][0]).sqrt());
        // The lamp spans some 400 stripes as seen from the floor; cutting the outer ones adds less than 1 in
        // 400.
        assert!(
            (radiance - 0.25 * expected).abs() < 4.0 * sigma + 0.25 * expected / 400.0,
            "{paths:?}: {radiance}, expected {}",
            0.25 * expected
        );
    }
}

/// A surface in even light shows its texture, linear and interpolated.
#[test]
fn textures_multiply_the_diffuse_colour() {
    let mut scene = scene(&under_white_sky("quad", 0.8, 0.0, 1.0));
    scene.materials[0].texture = Some(
        Texture {
            size: [2, 1],
            wrap: [Wrap::Clamp; 2],
            filter: Filter::Linear,
            texels: vec![[0, 0, 0, 255], [255, 188, 0, 255]],
        }
        .into(),
    );
    for (x, share) in [(-0.4, 0.0), (0.0, 0.5), (0.125, 0.75), (0.4, 1.0)] {
        let (mean, error) = mean_radiance(&scene, 1, 1 << 10, |_| (v(x, 1.0, 0.1), Vec3A::NEG_Y));
        // sRGB 188/255 is 0.50289 linear; `mean_radiance` looks at green.
        let expected = 0.8 * share * 0.502_886;
        assert!(
            (mean - expected).abs() < 4.0 * error + 1e-5,
            "at {x}: {mean} ± {error}, expected {expected}"
        );
    }
}

/// GGX under a white sky reflects its directional albedo, here by quadrature in double precision: glTF 2.0,
/// appendix B, with Smith's height-correlated visibility.
#[test]
fn ggx_albedo_by_quadrature() {
    for (metallic, roughness, tilt) in [
        (1.0, 0.32, 0.0),
        (1.0, 0.5, 1.0),
        (1.0, 1.0, 0.5),
        (0.0, 0.32, 1.3),
        (0.0, 0.7, 0.0),
        (0.5, 0.4, 0.8),
    ] {
        let material = Ggx { base_color: [0.6; 3], metallic: metallic as f32, roughness: roughness as f32 };
        assert_albedo(Brdf::Ggx(material), tilt, ggx(0.6, metallic, roughness));
    }
}

/// The same of Cook and Torrance's, in their own form.
#[test]
fn cook_torrance_albedo_by_quadrature() {
    for (fresnel, slope, tilt) in
        [(1.0, 0.1, 0.0), (1.0, 0.3, 1.0), (0.04, 0.1, 1.3), (0.6, 0.5, 0.8), (0.2, 1.0, 0.5)]
    {
        let (fresnel_f32, roughness) = (fresnel as f32, slope as f32);
        let material = CookTorrance { kd: [0.2; 3], ks: [0.8; 3], fresnel: fresnel_f32, roughness };
        assert_albedo(Brdf::CookTorrance(material), tilt, |[nh, nl, nv, vh]| {
            let distribution =
                (-(1.0 - nh * nh) / (nh * slope).powi(2)).exp() / (PI * slope.powi(2) * nh.powi(4));
            let masking = (2.0 * nh * nv / vh).min(2.0 * nh * nl / vh).min(1.0);
            let reflectance = fresnel + (1.0 - fresnel) * (1.0 - vh).powi(5);
            0.2 / PI + 0.8 * reflectance * distribution * masking / (4.0 * nl * nv)
        });
    }
}

/// That a floor of `material` under a white sky looks as `brdf` says, of the cosines n·h, n·l, n·v and v·h, seen
/// from `tilt` off the normal.
fn assert_albedo(material: Brdf, tilt: f64, brdf: impl Fn([f64; 4]) -> f64) {
    let mut scene = scene(&under_white_sky("quad", 0.5, 0.0, 1.0));
    scene.materials[0].brdf = material;
    let (sine, cosine) = (f64::sin(tilt) as f32, f64::cos(tilt) as f32);
    let (mean, error) = mean_radiance(&scene, 1, 1 << 17, |[x, y]| {
        let target = v(0.1 * x, 0.0, 0.1 * y);
        (target + 2.0 * v(sine, cosine, 0.0), -v(sine, cosine, 0.0))
    });
    let expected = albedo(tilt, brdf);
    assert!(
        (mean - expected).abs() < 4.0 * error + 2e-4,
        "{material:?} {tilt}: {mean} ± {error}, expected {expected}"
    );
    // Of a white lobe that loses nothing the quadrature may find a little more than all.
    assert!(error < 0.01 * expected && expected < 1.001, "{material:?} {tilt}: {mean} ± {error}");
}

fn ggx(base: f64, metallic: f64, roughness: f64) -> impl Fn([f64; 4]) -> f64 {
    let alpha2 = roughness.powi(4);
    move |[nh, nl, nv, vh]| {
        let distribution = alpha2 / (PI * (nh * nh * (alpha2 - 1.0) + 1.0).powi(2));
        let lambda = |a: f64, b: f64| a * (b * b * (1.0 - alpha2) + alpha2).sqrt();
        let visibility = 0.5 / (lambda(nl, nv) + lambda(nv, nl));
        let f0 = 0.04 + (base - 0.04) * metallic;
        let fresnel = f0 + (1.0 - f0) * (1.0 - vh).powi(5);
        (1.0 - fresnel) * base * (1.0 - metallic) / PI + fresnel * distribution * visibility
    }
}

/// ∫ ρ cos θ dω by the midpoint rule.
fn albedo(tilt: f64, brdf: impl Fn([f64; 4]) -> f64) -> f64 {
    let (n_theta, n_phi) = (1500, 1500);
    let view = [tilt.sin(), tilt.cos(), 0.0];
    let mut sum = 0.0;
    for i in 0..n_theta {
        let theta = (i as f64 + 0.5) / n_theta as f64 * PI / 2.0;
        for j in 0..n_phi {
            let phi = (j as f64 + 0.5) / n_phi as f64 * PI;
            let light = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
            let half: Vec<f64> = view.iter().zip(light).map(|(a, b)| a + b).collect();
            let length = half.iter().map(|x| x * x).sum::<f64>().sqrt();
            let v_dot_h = half.iter().zip(view).map(|(h, v)| h * v).sum::<f64>() / length;
            let [nl, nv] = [light[1], view[1]];
            sum += brdf([half[1] / length, nl, nv, v_dot_h]) * nl * theta.sin();
        }
    }
    // Both halves of the circle.
    sum * 2.0 * (PI / 2.0 / n_theta as f64) * (PI / n_phi as f64)
}

/// Two parallel unit squares at distance 1 exchange the share 0.19982 (Howell's catalogue C-11).
#[test]
fn form_factor_of_parallel_squares() {
    let text = LIT_FLOOR
        .replace("scale = 10.0", "scale = 1.0")
        .replace("radiance = [2.0, 2.0, 2.0]", "radiance = [1, 1, 1]")
        .replace("0.8, 0.8, 0.8", "1, 1, 1");
    let (mean, error) =
        mean_radiance(&scene(&text), 1, 1 << 17, |[x, y]| (v(x - 0.5, 0.5, y - 0.5), Vec3A::NEG_Y));
    // The mean over the square of E/π with unit radiance is the form factor itself.
    assert!((mean - 0.199_82).abs() < 4.0 * error + 2e-5, "{mean} ± {error}");
    assert!(error < 1e-3);
}

/// No light comes from nowhere: materials that reflect at most what they receive stay below the sky's
/// radiance, whatever the geometry.
#[test]
fn energy_is_never_gained() {
    for (kd, shininess) in [(0.3, 1.0), (0.2, 20.0), (0.0, 200.0)] {
        let ks = (1.0 - kd) / glossy_albedo(shininess);
        let text = under_white_sky("box", kd, ks, shininess)
            + "transform = { translation = [-0.6, 0, 0] }\n[[object]]\nname = 'p'\nmaterial = 'm'\nshape = 'box'\ntransform = { translation = [0.6, 0.2, 0.1] }\n";
        let image = render(&scene(&text), [24, 24], 256, 40, Paths::Best, 5);
        for (radiance, variance) in image.radiance.iter().flatten().zip(image.variance.iter().flatten()) {
            assert!(
                *radiance <= 1.0 + 5.0 * variance.sqrt() + 1e-3,
                "kd {kd}, s {shininess}: {radiance} ± {}",
                variance.sqrt()
            );
        }
    }
}

/// Both estimators must agree where both apply: two reflections in a room with glossy walls.
#[test]
fn best_and_gather_paths_agree() {
    let scene = crate::support::library_scene("cornell-knot");
    let best = render(&scene, [32, 32], 1024, 2, Paths::Best, 1);
    let gather = render(&scene, [32, 32], 1024, 2, Paths::Gather, 2);
    let (mut statistic, mut count) = (0.0, 0);
    for (((a, va), b), vb) in
        best.radiance.iter().zip(&best.variance).zip(&gather.radiance).zip(&gather.variance)
    {
        for channel in 0..3 {
            let variance = f64::from(va[channel] + vb[channel]);
            if variance > 1e-12 {
                statistic += f64::from(a[channel] - b[channel]).powi(2) / variance;
                count += 1;
            }
        }
    }
    // Variances are upper bounds, so the mean of z² is at most 1 plus its own noise (channels share paths: a
    // third as many are independent).
    let mean = statistic / f64::from(count);
    assert!(
        mean < 1.0 + 5.0 * (2.0 / (f64::from(count) / 3.0)).sqrt(),
        "mean z² = {mean} over {count} channels"
    );
}
