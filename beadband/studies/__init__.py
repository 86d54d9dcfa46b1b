"""Many runs: sweeps, maps, and the studies that test the method and the paper."""
