// Angles, exact to some 1e-7: the built-in functions may be off by 4096 units in the last place.

#import pi

// atan on 0..=1: a least-maximum fit of atan(t)/t by a polynomial in t².
fn atan_of_share(t: f32) -> f32 {
    let z = t * t;
    var sum = 0.0024567190557718277;
    sum = sum * z - 0.014401335269212723;
    sum = sum * z + 0.03978118672966957;
    sum = sum * z - 0.07234854251146317;
    sum = sum * z + 0.1049894466996193;
    sum = sum * z - 0.14161229133605957;
    sum = sum * z + 0.19985906779766083;
    sum = sum * z - 0.33332598209381104;
    sum = sum * z + 0.9999998807907104;
    return sum * t;
}

// The angle of (x, y), −π..=π.
fn angle_of(y: f32, x: f32) -> f32 {
    let largest = max(abs(x), abs(y));
    let share = min(abs(x), abs(y)) / select(largest, 1.0, largest == 0.0);
    var angle = atan_of_share(share);
    if abs(y) > abs(x) {
        angle = 0.5 * PI - angle;
    }
    if x < 0.0 {
        angle = PI - angle;
    }
    return select(angle, -angle, y < 0.0);
}
