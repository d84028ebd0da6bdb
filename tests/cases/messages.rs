//! Mistakes in scenes, states, animations and command lines: key, line and remedy.
