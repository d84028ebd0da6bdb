// A band of the film as the camera sees it.
struct View {
    eye_in_world: vec3<f32>,
    // Nothing closer than this is drawn, metres.
    near: f32,
    // Film position (u, v) lies in the direction forward + u·right + v·up.
    forward: vec3<f32>,
    // v in the middle of the band.
    band_middle: f32,
    right: vec3<f32>,
    // Half the range of v over the band.
    band_reach: f32,
    up: vec3<f32>,
    // Number of the band's first row of pixels.
    first_row: f32,
    // Factor on all light.
    gain: vec3<f32>,
    // Pixels of a row of the film.
    width: f32,
    // Rows of the film.
    height: f32,
}
