#include "voxelserver/data/imagery/bands.hpp"

#include <gdal_priv.h>

#include <initializer_list>
#include <string_view>

#include "common/util/letter_case.hpp"

namespace terravox::imagery {
namespace {

bool letter(char c) noexcept {
    return c >= 'a' && c <= 'z';
}

/// "irc" is a word of "ortho_irc1.tif", not of "circle.tif".
bool has_word(const std::string& text, std::initializer_list<std::string_view> words) {
    for (const std::string_view word : words)
        for (std::size_t at = text.find(word); at != std::string::npos;
             at = text.find(word, at + 1))
            if ((at == 0 || !letter(text[at - 1])) &&
                (at + word.size() == text.size() || !letter(text[at + word.size()])))
                return true;
    return false;
}

bool says_near_infrared(GDALRasterBand& band) {
#if GDAL_VERSION_NUM >= GDAL_COMPUTE_VERSION(3, 10, 0)
    if (band.GetColorInterpretation() == GCI_NIRBand)
        return true;
#endif
    return has_word(util::lower_case(band.GetDescription()),
                    {"nir", "near infrared", "near-infrared", "near_infrared", "nearinfrared",
                     "infrared", "pir", "ir"});
}

bool says_anything_else(GDALRasterBand& band) {
    const GDALColorInterp meaning = band.GetColorInterpretation();
    return (meaning != GCI_Undefined && meaning != GCI_GrayIndex) ||
           std::string_view(band.GetDescription()) != "";
}

}  // namespace

BandRoles roles_of(GDALDataset& image, const std::string& file_name) {
    BandRoles roles;
    const int bands = image.GetRasterCount();
    const std::string name = util::lower_case(file_name);
    if (image.GetRasterBand(1)->GetColorTable() != nullptr)
        return {1, 1, 1, 0, true};
    bool infrared_described = false;
    for (int b = 1; b <= bands; ++b) {
        GDALRasterBand& band = *image.GetRasterBand(b);
        const GDALColorInterp meaning = band.GetColorInterpretation();
        const std::string says = util::lower_case(band.GetDescription());
        if (says_near_infrared(band)) {
            roles.nir = roles.nir == 0 ? b : roles.nir;
            infrared_described = true;
        } else if (meaning == GCI_RedBand || says == "red")
            roles.red = roles.red == 0 ? b : roles.red;
        else if (meaning == GCI_GreenBand || says == "green")
            roles.green = roles.green == 0 ? b : roles.green;
        else if (meaning == GCI_BlueBand || says == "blue")
            roles.blue = roles.blue == 0 ? b : roles.blue;
    }
    // Described as near infrared, but tagged as if red, green, blue.
    if (infrared_described && roles.nir == 1 && roles.blue != 0 && bands < 4)
        roles = {2, 3, 0, 1, false};
    if (infrared_described && roles.red != 0)
        return roles;
    if (bands >= 3 && has_word(name, {"irc", "cir"}))
        return {2, 3, 0, 1, false};
    if (bands < 3)
        return {1, 1, 1, 0, false};
    if (roles.red == 0 || roles.green == 0 || roles.blue == 0)
        roles = {1, 2, 3, roles.nir > 3 ? roles.nir : 0, false};
    if (roles.nir == 0 && bands >= 4 &&
        (has_word(name, {"rgbi", "rgbn", "rgbnir"}) ||
         !says_anything_else(*image.GetRasterBand(4))))
        roles.nir = 4;
    return roles;
}

}  // namespace terravox::imagery
