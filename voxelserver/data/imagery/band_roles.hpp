#pragma once

#include <string>

class GDALDataset;

namespace terravox::imagery {

/// Assignment of an image's bands: GDAL's band numbers from 1, 0 = not present.
struct BandRoles {
    int red = 0;
    int green = 0;
    int blue = 0;
    int nir = 0;
    bool palette = false;  ///< the first band holds indices into a colour table
    /// What the file says of its bands and what was not followed, for a warning; empty: nothing.
    std::string doubt = {};
    [[nodiscard]] bool colour() const noexcept { return blue != 0; }
};

/// Determines what the bands hold, by these rules, in this order:
/// 1. per band, the metadata of the file: a colour interpretation (near infrared where GDAL
///    supports it: 3.10), or a description that has a word such as "red", "green", "blue" ("B04
///    (red)", not "red edge"), "nir", "near infrared", "pir", or the letters R, G, B alone, or,
///    where none says a colour, B02, B03, B04 of Sentinel-2 and Landsat 8; a description counts
///    more than a colour interpretation, since many programs write that of RGB for any three bands;
/// 2. a file name with the word "irc" or "cir" (no letter before or after it:
///    "ortho_irc_2021.tif"), three bands or more: near infrared, red, green;
/// 3. a file name with the word "rgbi", "rgbn" or "rgbnir": the fourth band is near infrared, even
///    if tagged as alpha;
/// 4. four bands or more, the fourth neither alpha nor described: near infrared;
/// 5. else red, green, blue in the order of the bands; fewer than three bands are grey.
///
/// An image that has only near infrared, red and green gives no colour: its blue is unknown, and a
/// made-up value would end up in the picture.
[[nodiscard]] BandRoles find_roles(GDALDataset& image, const std::string& file_name);

}  // namespace terravox::imagery
