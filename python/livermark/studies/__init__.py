"""Studies whose statistics numpy and OpenTURNS compute; the commands of the program start them."""
