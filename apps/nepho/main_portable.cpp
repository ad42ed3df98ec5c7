// nepho_portable: the program for machines that lack our libraries. Of rasters it reads the baked Earth
// (docs/packaging.md).
#include "nepho/run_main.h"

int main(int argc, char** argv) { return nepho::run_main(argc, argv, nepho::baked_rasters()); }
