"""Studies: verbs over further axes, in chunks that outgrow neither memory nor an interruption."""
