#pragma once

/// Marks what programs share with the library, whatever visibility they are compiled with. The
/// names that the library shows are listed in raytracer/apps/library/symbols.map.
#define TERRAVOX_API __attribute__((visibility("default")))
