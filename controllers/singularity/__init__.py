"""The singularity-consistent method: motion along a path without the Jacobian's inverse."""
