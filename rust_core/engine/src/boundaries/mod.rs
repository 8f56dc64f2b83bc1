//! Boundaries, one file each. To add one: write its file, and add its line to [`build`].
