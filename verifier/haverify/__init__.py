"""haverify: formal verification of hybrid systems, with certificates anybody can re-check."""
