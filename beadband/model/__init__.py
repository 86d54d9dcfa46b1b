"""What is true before anything is computed: bands, laws, the wedge, exact limits, calibration, scales."""
