//! Sound containers whose content breaks the rules of its kind: BRDF bases and transfer images.

use crate::support::raw_file::RawSection;
use crate::support::refusing::{assert_forged_refused, assert_refused};
use crate::support::samples;
use half::f16;
use relume_formats::container::Stored as _;
use relume_formats::kinds::brdf_basis::Functions;
use relume_formats::kinds::transfer_images::{Head, Image, Later};
use relume_formats::kinds::{BrdfBasis, TransferImages};
use std::sync::Arc;

/// Lobes of a Blinn-Phong basis.
fn lobes(basis: &mut BrdfBasis) -> &mut Vec<f32> {
    match &mut basis.functions {
        Functions::BlinnPhong { lobes } => lobes,
        Functions::Microfacet { .. } => panic!("not of this model"),
    }
}

#[test]
fn broken_bases() {
    type Change = fn(&mut BrdfBasis);
    let cases: [(Change, &str); 18] = [
        (|b| b.parameters.swap(0, 1), "increasing parameters"),
        (|b| b.parameters[1] = f32::NAN, "increasing parameters"),
        (|b| *b.parameters.last_mut().unwrap() = f32::INFINITY, "section `parameters`: element"),
        (|b| (b.parameters, b.coefficients) = (vec![1.0], vec![0.0; 3]), "needs 2 to 4096"),
        (|b| b.coefficients[2] = f32::NAN, "section `coefficients`: element 2"),
        (|b| lobes(b)[77] = f32::NEG_INFINITY, "section `lobes`: element 77"),
        (
            |b| (b.coefficients, *lobes(b)) = (vec![1.0; b.parameters.len()], Vec::new()),
            "holds 1 bases, 2 to 32",
        ),
        (|b| *b = samples::basis(1, 33, true), "holds 33 bases, 2 to 32"),
        (
            |b| *b.parameters.last_mut().unwrap() = 199.0,
            "section `parameters`: runs from 1 to 199, expected 1 to 200",
        ),
        (|b| b.parameters[0] = -5.0, "section `parameters`: runs from -5 to 200"),
        (
            |b| b.parameters.iter_mut().for_each(|p| *p = 1.0 + *p * 1e-3),
            "section `parameters`: runs from 1.001 to 1.2",
        ),
        (|b| b.coefficients[1] = 3e38, "section `coefficients`: element 1, 3e38, is beyond 10000.0"),
        (|b| lobes(b)[5] = -3e38, "section `lobes`: element 5"),
        (|b| b.meta.error_between.mean = f64::NAN, "section `meta`: errors"),
        (|b| b.meta.error_at_samples.worst = -1.0, "section `meta`: errors"),
        (|b| b.meta.error_between.mean = 2.0 * b.meta.error_between.worst, "section `meta`: mean error"),
        (
            |b| lobes(b).iter_mut().for_each(|v| *v *= 1000.0),
            "section `coefficients`: coefficients and functions miss the model's lobes by",
        ),
        (
            |b| b.coefficients.iter_mut().for_each(|v| *v *= 1000.0),
            "section `coefficients`: coefficients and functions miss",
        ),
    ];
    let sound = samples::basis(3, 3, true);
    for (change, expected) in cases {
        let mut basis = sound.clone();
        change(&mut basis);
        assert_refused(&basis, expected);
    }
    let transposed = |s: &mut RawSection| s.shape.reverse();
    assert_forged_refused(&sound, "coefficients", transposed, "section `coefficients`: has shape");
    assert_forged_refused(&sound, "lobes", transposed, "section `lobes`: has shape");
    assert_forged_refused(&sound, "lobes", |s| s.element = 2, "section `lobes`: holds u32, expected f32");
    assert_forged_refused(
        &sound,
        "lobes",
        |s| s.name = "lobe".to_owned(),
        "expected section `lobes`, `roughness` or `slopes` here",
    );
    assert_forged_refused(&sound, "parameters", |s| s.shape.push(1), "section `parameters`: has shape");
    let many = |s: &mut RawSection| *s = RawSection::new(&s.name, 4, &[4097], 1, &[0; 4 * 4097]);
    assert_forged_refused(&sound, "parameters", many, "needs 2 to 4096");
}

/// Roughness and weights of a GGX basis.
fn samples_of(basis: &mut BrdfBasis) -> (&mut Vec<f32>, &mut Vec<f32>) {
    match &mut basis.functions {
        Functions::Microfacet { roughness, weights, .. } => (roughness, weights),
        Functions::BlinnPhong { .. } => panic!("not of this model"),
    }
}

#[test]
fn broken_ggx_bases() {
    type Change = fn(&mut BrdfBasis);
    let cases: [(Change, &str); 15] = [
        (|b| b.parameters.reverse(), "increasing parameters"),
        (
            |b| b.parameters[0] = 0.13,
            "section `parameters`: runs from 0.13 to 1, expected 0.32 to 1, at most 0.14 to 1",
        ),
        (|b| b.parameters[0] = 0.33, "section `parameters`: runs from 0.33 to 1, expected 0.32 to 1"),
        (|b| samples_of(b).1[9] = 1e31, "section `weights`: element 9"),
        (|b| b.coefficients[11] = f32::NAN, "section `coefficients`: element 11"),
        (|b| samples_of(b).0[1] = 0.0, "section `roughness`: needs 1 to 64 values of 0.14 to 1"),
        (|b| samples_of(b).0[1] = 0.13, "section `roughness`: needs 1 to 64 values of 0.14 to 1"),
        (|b| samples_of(b).0[0] = 1.01, "section `roughness`: needs 1 to 64 values of 0.14 to 1"),
        (|b| samples_of(b).0[0] = f32::NAN, "section `roughness`: element 0"),
        (|b| samples_of(b).1[9] = f32::INFINITY, "section `weights`: element 9"),
        (
            |b| samples_of(b).1.iter_mut().for_each(|v| *v *= 1000.0),
            "section `coefficients`: coefficients and functions miss the model's",
        ),
        (
            |b| b.coefficients.iter_mut().for_each(|v| *v *= 1000.0),
            "section `coefficients`: coefficients and functions miss",
        ),
        (|b| *b = samples::ggx_basis(1, 2, 65), "section `roughness`: needs 1 to 64"),
        (
            |b| (b.coefficients, *samples_of(b).1) = (vec![1.0; 2 * b.parameters.len()], Vec::new()),
            "holds 1 bases, 2 to 32",
        ),
        (|b| *b = samples::ggx_basis(1, 33, 2), "holds 33 bases, 2 to 32"),
    ];
    let sound = samples::ggx_basis(3, 3, 2);
    for (change, expected) in cases {
        let mut basis = sound.clone();
        change(&mut basis);
        assert_refused(&basis, expected);
    }
    let none = |s: &mut RawSection| *s = RawSection::new(&s.name, 4, &[0], 1, &[]);
    assert_forged_refused(&sound, "roughness", none, "section `roughness`: needs 1 to 64");
    assert_forged_refused(&sound, "roughness", |s| s.shape.push(1), "section `roughness`: has shape [2, 1]");
    let transposed = |s: &mut RawSection| s.shape.reverse();
    assert_forged_refused(
        &sound,
        "weights",
        transposed,
        "section `weights`: has shape [5, 2], expected [2, 5]",
    );
    assert_forged_refused(
        &sound,
        "coefficients",
        |s| s.shape.swap(1, 2),
        "section `coefficients`: has shape",
    );
    // Of one part only, as a basis of the other model has.
    let one_part = |s: &mut RawSection| {
        *s = RawSection::new(&s.name, 4, &[s.shape[0], 1, 3], 1, &s.raw()[..s.raw_bytes as usize / 2])
    };
    assert_forged_refused(&sound, "coefficients", one_part, "section `coefficients`: has shape");
}

#[test]
fn broken_transfer_images() {
    type Change = fn(&mut Head);
    let cases: [(Change, &str); 24] = [
        (|h| h.meta.size = [0, 3], "film size [0, 3]"),
        (|h| h.meta.size = [3, 16_385], "film size [3, 16385]"),
        (|h| h.meta.materials[1] = "m0".to_owned(), "are called `"),
        (|h| h.meta.chromaticity = Some([1.0, 2.0, 0.0]), "chromaticity is outside"),
        (|h| h.meta.chromaticity = Some([1.0, f32::NAN, 0.0]), "chromaticity is outside"),
        (|h| h.meta.editable_fragments = h.pixel.len() as u32 + 1, "do not fit the film"),
        (|h| h.meta.editable_fragments += 1, "not in order, or of a class"),
        (|h| h.meta.editable_fragments -= 1, "not in order, or of a class"),
        (|h| h.pixel[0] = 12, "outside the film"),
        (|h| h.pixel.swap(0, 4), "not in order"),
        (|h| (h.pixel[1], h.class[1]) = (h.pixel[0], h.class[0]), "not in order"),
        (|h| h.class[0] = 3, "of a class that is not there"),
        (|h| *h.class.last_mut().unwrap() = 3, "of a class that is not there"),
        (|h| h.coverage[0] = f16::ZERO, "a coverage is outside"),
        (|h| h.coverage[0] = f16::from_f32(1.01), "a coverage is outside"),
        (|h| h.coverage[0] = f16::NAN, "a coverage is outside"),
        (|h| h.scales[2] = f32::INFINITY, "section `scales`: element 2"),
        (|h| h.scales[2] = 3e38, "section `scales`: element 2, 3e38, is beyond 1e18"),
        (|h| h.scales[2] = -1.0, "a scale is negative"),
        (|h| h.scales[2] = 0.3, "section `scales`: scale 3e-1 is no power of 2"),
        (|h| h.scales[2] = 2f32.powi(60), "section `scales`: element 2, 1.1529215e18, is beyond 1e18"),
        (|h| h.coverage.fill(f16::from_f32(0.9)), "section `fragments/coverage`: the fragments of pixel"),
        (|h| h.meta.chromaticity = Some([0.5, 0.25, 0.5]), "has no channel of 1"),
        (|h| h.meta.materials[1] = "\u{7}".to_owned(), "has control characters"),
    ];
    let sound = samples::images(3, 2, 3, true, [4, 3]);
    for (change, expected) in cases {
        let mut head = (*sound.head).clone();
        change(&mut head);
        // Images after a broken head must not matter, nor could all of them be written.
        assert_refused(&TransferImages { head: Arc::new(head), images: Vec::new() }, expected);
    }
}

#[test]
fn broken_counts_of_transfer_images() {
    let sound = samples::images(3, 2, 3, true, [4, 3]);
    let with_head = |change: &dyn Fn(&mut Head)| {
        let mut head = (*sound.head).clone();
        change(&mut head);
        TransferImages { head: Arc::new(head), images: Vec::new() }
    };
    assert_refused(&with_head(&|_| ()), "0 images, expected 24");
    assert_refused(&with_head(&|h| h.meta.bases = 1), "2 materials and 1 bases are out of range");
    assert_refused(&with_head(&|h| h.meta.bases = 33), "2 materials and 33 bases are out of range");
    // In the record: two numbers of 4 bytes, then a list of two names of 2 characters, then the number of
    // bases.
    let endless = |s: &mut RawSection| {
        let mut raw = s.raw();
        let at = 8 + 8 + 2 * (8 + 2);
        assert_eq!(raw[at..at + 4], [3, 0, 0, 0]);
        raw[at..at + 4].fill(255);
        s.set_raw(&raw);
    };
    assert_forged_refused(&sound, "meta", endless, "2 materials and 4294967295 bases are out of range");
    assert_refused(
        &with_head(&|h| h.meta.materials = (0..65).map(|i| i.to_string()).collect()),
        "65 materials and 3 bases",
    );
    assert_refused(&with_head(&|h| h.meta.materials.clear()), "0 materials and 3 bases");
    assert_refused(&with_head(&|h| h.scales.truncate(3)), "section `scales`: has shape [3]");
    let three = |s: &mut RawSection| *s = RawSection::new(&s.name, s.element, &[3], 1, &s.raw()[..6]);
    assert_forged_refused(&sound, "fragments/class", three, "section `fragments/class`: has shape [3]");
    assert_forged_refused(&sound, "fragments/coverage", three, "section `fragments/coverage`: has shape [3]");
}

#[test]
fn broken_images() {
    let sound = samples::images(3, 2, 3, true, [4, 3]);
    let mut not_finite = sound.clone();
    not_finite.images[4].values[1] = f16::INFINITY;
    assert_refused(&not_finite, "holds what is no half");
    let rgb = sound.images.iter().position(|i| i.slot == 0).unwrap();
    let mut short = sound.clone();
    short.images.truncate(rgb);
    assert_refused(&short, &format!("{rgb} images, expected"));
    for name in ["image/9999", "image/0", "image/00001", "picture/0001", "image/"] {
        assert_forged_refused(
            &sound,
            "image/0001",
            |s| s.name = name.to_owned(),
            "is no image of this layout",
        );
    }
    let grey = |s: &mut RawSection| s.shape = vec![1, s.shape.iter().product()];
    assert_forged_refused(&sound, "image/0000", grey, "section `image/0000`: has shape [1, ");
    // The step is the first number.
    let step = |s: &mut RawSection| {
        let mut raw = s.raw();
        raw[..2].copy_from_slice(&40u16.to_le_bytes());
        s.set_raw(&raw);
    };
    assert_forged_refused(&sound, "image/0000", step, "section `image/0000`: holds what is no half");
}

/// Of one image: all values 0, beyond the range of scales, below half of it, with a scale of 0, and of
/// another sign.
#[test]
fn images_that_do_not_fit_their_scales() {
    let sound = samples::images(3, 2, 3, true, [4, 3]);
    let place = |slot: usize| sound.images.iter().position(|i| i.slot == slot).unwrap();
    type Change = fn(&mut Image);
    let cases: [(Change, &str); 5] = [
        (|i| i.values.fill(f16::ZERO), "its largest value is 0, outside"),
        (|i| i.values.fill(f16::from_f32(65_504.0)), "its largest value is 65504, outside"),
        (|i| i.values.iter_mut().for_each(|v| *v = f16::from_f32(v.to_f32() * 0.25)), "its largest value is"),
        (|i| i.values.iter_mut().for_each(|v| *v = -*v), "radiance of diffuse paths is below 0"),
        (|i| i.values[0] = f16::from_f32(-1.0), "radiance of diffuse paths is below 0"),
    ];
    for (change, expected) in cases {
        let mut images = sound.clone();
        change(&mut images.images[place(0)]);
        assert_refused(&images, expected);
    }
    let mut dark = sound.clone();
    Arc::make_mut(&mut dark.head).scales.fill(0.0);
    assert_refused(&dark, "and scale 0");
    // What glossy bases make of light may be negative; that it all is, is another picture.
    let mut signed = sound.clone();
    let slot = sound.head.layout().slots.iter().position(|slot| slot.eye_basis > 0).unwrap();
    signed.images[place(slot)].values.iter_mut().for_each(|v| *v = -*v);
    signed.to_bytes(relume_formats::Place::file("a.relume")).unwrap();
}

#[test]
fn broken_later_reflections() {
    type Change = fn(&mut Later);
    let cases: [(Change, &str); 6] = [
        (|l| l.degree = 3, "of degree 3"),
        (|l| l.albedos.truncate(2), "of other bases or materials"),
        (|l| l.returns.push(0.0), "of other bases or materials"),
        (|l| l.albedos[0] = f32::NAN, "albedo of a basis function"),
        (|l| l.textures[1][2] = 1.5, "mean of a texture"),
        (|l| l.returns[0] = 1.2, "more light returns"),
    ];
    let sound = samples::images_of_all(3, 2, 3, true, [4, 3]);
    for (change, expected) in cases {
        let mut images = sound.clone();
        let head = Arc::make_mut(&mut images.head);
        change(head.later.as_mut().unwrap());
        assert_refused(&images, expected);
    }
}
