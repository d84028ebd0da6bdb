//! What is computed again when something changes.

use super::*;
use crate::methods::transfer_tensor::stage::Changed;

#[test]
fn no_more_is_computed_than_has_changed() {
    let Some(gpu) = gpu() else { return };
    let bundle = Bundle::write();
    let (mut method, later) = load(&gpu, &bundle, 1);
    let mut changed = |look: &Look, arrivals: Vec<Arrival>| {
        arrivals.into_iter().for_each(|arrival| method.section_arrived(&gpu, arrival).unwrap());
        method.update(&gpu, look).unwrap();
        let changed = method.stage.as_ref().unwrap().changed();
        draw(&gpu, &mut method, look);
        changed
    };
    let none = Changed::default();
    let all = Changed { light: true, materials: true, blocks: true, reflected: false, eye: true };
    let first = states()[0].look(&bundle);
    assert_eq!(changed(&first, Vec::new()), all);
    assert_eq!(changed(&first, Vec::new()), none);
    let mut look = first;
    look.camera.fov_deg = 20.0;
    look.camera.target = [0.3; 3];
    assert_eq!(changed(&look, Vec::new()), none, "the eye stays where it is");
    look.camera.position = [1.0, 0.0, 3.0];
    assert_eq!(changed(&look, Vec::new()), Changed { eye: true, ..none });
    look.materials.set("b", edited()[1]);
    assert_eq!(changed(&look, Vec::new()), Changed { materials: true, ..none });
    look.environment = Some(environment("noise", 0.0, [2.0; 3]));
    assert_eq!(changed(&look, Vec::new()), none, "gain is a factor");
    look.environment = Some(environment("noise", 9.0, [2.0; 3]));
    assert_eq!(changed(&look, Vec::new()), Changed { light: true, ..none });
    look.environment = Some(environment("sun", 9.0, [2.0; 3]));
    assert_eq!(changed(&look, Vec::new()), Changed { light: true, ..none });
    assert_eq!(changed(&look, later), Changed { blocks: true, reflected: true, ..none });
}

/// After changes one at a time frames are those of a player that has seen nothing before.
#[test]
fn what_was_kept_is_what_would_be_computed() {
    let Some(gpu) = gpu() else { return };
    let bundle = Bundle::write();
    let mut method = load_all(&gpu, &bundle);
    let mut look = states()[0].look(&bundle);
    let changes: [&dyn Fn(&mut Look); 5] = [
        &|look| look.materials.set("a", edited()[0]),
        &|look| look.camera.position = [2.0, 1.0, 0.3],
        &|look| look.environment = Some(environment("sun", 20.0, [1.0; 3])),
        &|look| look.materials.set("c", edited()[2]),
        &|look| look.environment = Some(environment("sun", 77.0, [1.0; 3])),
    ];
    draw(&gpu, &mut method, &look);
    for change in changes {
        change(&mut look);
        draw(&gpu, &mut method, &look);
        let mut fresh = load_all(&gpu, &bundle);
        draw(&gpu, &mut fresh, &look);
        assert_eq!(vertices(&gpu, &method), vertices(&gpu, &fresh));
    }
}
