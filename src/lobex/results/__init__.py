"""What the verbs hand back: labelled arrays that print, plot, save and load themselves."""
