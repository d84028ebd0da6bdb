//! OBJ, PLY and OFF as other programs write them.
