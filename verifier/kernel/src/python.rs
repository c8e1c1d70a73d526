//! The Python face.

use pyo3::prelude::*;

#[pymodule]
mod _kernel {
    use super::*;

    /// The hash of the sources this kernel was built from.
    #[pyfunction]
    fn source_hash() -> &'static str {
        env!("KERNEL_SOURCE_HASH")
    }
}
