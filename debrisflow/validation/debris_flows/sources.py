"""What the references of several flows are called."""

STUDY = "a Japanese study of debris flows by MPS (no usable citation, see the page Sources)"
TAKAHASHI = "Takahashi 1978, Journal of the Hydraulics Division ASCE 104, 1153"
