//! Hostile names, two bakes at once, full disks, files that are none.
