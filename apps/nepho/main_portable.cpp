// nepho_portable: the program for machines that lack our libraries. It reads no rasters (tests/tools/bundle.sh).
#include "nepho/run_main.h"

int main(int argc, char** argv) { return nepho::run_main(argc, argv, nepho::no_rasters()); }
