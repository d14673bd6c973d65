"""Static pictures, stills and animations of a run."""
