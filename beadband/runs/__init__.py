"""One run: the release or launch of one scene, its folder, its measurement and its results."""
