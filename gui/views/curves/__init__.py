"""The live curves: sigma_i, L1 norm and errors over the iterations."""
