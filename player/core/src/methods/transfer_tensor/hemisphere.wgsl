// What vertices see of the hemisphere about them: the GPU twin of `relume_formats::basis::hemisphere`.

#import angle

// Texels along a side.
const SEEN_SIDE = 24u;

// Where in the square a unit vector is whose z is above 0, each coordinate in 0..=1.
fn place_in_square(direction: vec3<f32>) -> vec2<f32> {
    // √(1 − z), exact about the normal.
    let r = length(direction.xy) / sqrt(1.0 + direction.z);
    let is_along_x = abs(direction.x) >= abs(direction.y);
    let angle = select(angle_of(direction.x, abs(direction.y)), angle_of(direction.y, abs(direction.x)), is_along_x);
    let aside = r * angle * (4.0 * FRAC_1_PI);
    let along_x = vec2<f32>(select(r, -r, direction.x < 0.0), aside);
    let along_y = vec2<f32>(aside, select(r, -r, direction.y < 0.0));
    return 0.5 * select(along_y, along_x, is_along_x) + 0.5;
}
