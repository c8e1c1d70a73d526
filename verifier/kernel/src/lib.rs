//! Numbers and sets with outward rounding: what is computed contains what is true.

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
compile_error!("the rounding arguments of this crate hold for x86_64 and aarch64 only");

#[cfg(feature = "python")]
mod python;
