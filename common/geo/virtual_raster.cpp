#include "common/geo/raster_gate.hpp"

#include <cpl_minixml.h>

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/text.hpp"

namespace terravox::geo {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxDepth = 4;  // a .vrt of .vrts
constexpr std::size_t kMaxText_bytes = std::size_t{64} << 20;

std::string in_quotes(std::string_view text) {
    constexpr std::size_t kShown = 120;
    return "'" + std::string(text.substr(0, kShown)) + "'";
}

/// The elements and attributes that a mosaic may have, in lower case. One list is enough: GDAL
/// finds either by the same name, case-insensitively.
constexpr std::string_view kKnownNames[] = {
    // The declaration of XML.
    "?xml", "version", "encoding",
    // The data set.
    "vrtdataset", "rasterxsize", "rasterysize", "srs", "dataaxistosrsaxismapping",
    "coordinateepoch", "geotransform", "metadata", "overviewlist", "resampling", "blockxsize",
    "blockysize",
    // Bands, their masks and overviews.
    "vrtrasterband", "datatype", "band", "description", "unittype", "offset", "scale",
    "categorynames", "category", "colorinterp", "colortable", "entry", "c1", "c2", "c3", "c4",
    "nodatavalue", "hidenodatavalue", "histograms", "histitem", "histmin", "histmax", "bucketcount",
    "includeoutofrange", "approximate", "histcounts", "maskband", "overview",
    // Sources.
    "simplesource", "complexsource", "averagedsource", "kernelfilteredsource", "kernel",
    "normalized", "size", "coefs", "sourcefilename", "relativetovrt", "shared", "sourceband",
    "sourceproperties", "srcrect", "dstrect", "xoff", "yoff", "xsize", "ysize", "nodata",
    "usemaskband", "lut", "scaleoffset", "scaleratio", "exponent", "srcmin", "srcmax", "dstmin",
    "dstmax", "colortablecomponent"};

/// @param name in lower case
bool is_known(std::string_view name) {
    return std::find(std::begin(kKnownNames), std::end(kKnownNames), name) != std::end(kKnownNames);
}

class Check {
public:
    void file(const fs::path& vrt, int depth) {
        if (depth > kMaxDepth)
            throw util::Error("virtual rasters in virtual rasters deeper than " +
                              std::to_string(kMaxDepth));
        // GDAL searches for sources in the folder of the file itself, not in that of a link to it.
        const fs::path own = fs::canonical(vrt);
        const auto tree = parsed(own);
        for (const CPLXMLNode* node = tree.get(); node != nullptr; node = node->psNext)
            check(*node, own.parent_path(), depth);
    }

private:
    using Tree = std::unique_ptr<CPLXMLNode, decltype(&CPLDestroyXMLNode)>;

    /// Parsed by GDAL's own parser, so that both read the same tree.
    Tree parsed(const fs::path& vrt) {
        const std::string text = util::read_text(vrt, kMaxText_bytes, "its text");
        m_bytes += text.size();
        if (m_bytes > kMaxText_bytes)
            throw util::Error("more than {} MiB of virtual raster", kMaxText_bytes >> 20);
        Tree tree(CPLParseXMLString(text.c_str()), &CPLDestroyXMLNode);
        if (!tree)
            throw util::Error("no XML");
        return tree;
    }

    void check(const CPLXMLNode& node, const fs::path& folder, int depth) {
        if (node.eType != CXT_Element && node.eType != CXT_Attribute)
            return;
        const std::string name = util::lower_case(node.pszValue);
        if (!is_known(name))
            throw util::Error(
                "a virtual raster with {}; allowed: mosaics of files next to or below it",
                in_quotes(node.pszValue));
        // Harmless with any content; references that GDAL may follow in it are checked once the
        // raster is open.
        if (name == "metadata")
            return;
        if (name == "srs")
            check_srs(node);
        if (name == "sourcefilename")
            check_source(node, folder, depth);
        for (const CPLXMLNode* child = node.psChild; child != nullptr; child = child->psNext)
            check(*child, folder, depth);
    }

    static void check_srs(const CPLXMLNode& node) {
        const std::string text = CPLGetXMLValue(&node, nullptr, "");
        if (text.empty())
            return;
        if (const std::string fault = fault_of_crs_text(text); !fault.empty())
            throw util::Error("its coordinate reference system: " + fault);
    }

    void check_source(const CPLXMLNode& node, const fs::path& folder, int depth) {
        const std::string text = CPLGetXMLValue(&node, nullptr, "");
        const auto refuse = [&](const char* why) {
            throw util::Error("the source {} {}; allowed: files next to or below the .vrt",
                              in_quotes(text), why);
        };
        if (node.eType != CXT_Element || text.empty())
            refuse("is no file's name");
        const fs::path named(text);
        // GDAL accepts names such as GTIFF_DIR:1:a.tif and http://host/a.tif, which are not
        // relative to anything.
        if (named.is_relative() && text.find(':') != std::string::npos)
            refuse("is no plain file's name");
        if (named.is_relative() &&
            std::string_view(CPLGetXMLValue(&node, "relativeToVRT", "0")) != "1")
            refuse("is relative to where the program runs");
        const fs::path source = folder / named;
        if (!lies_in(source, folder))
            refuse("lies elsewhere");
        std::error_code failed;
        const fs::file_status status = fs::status(source, failed);
        if (!fs::exists(status))
            return;  // its part of the image will count as damaged, and as a hole
        if (!fs::is_regular_file(status))
            refuse("is no file");
        if (util::lower_extension(source) == ".vrt")
            file(source, depth + 1);
    }

    std::size_t m_bytes = 0;
};

}  // namespace

bool lies_in(const fs::path& file, const fs::path& folder) {
    std::error_code failed;
    const fs::path inside = fs::weakly_canonical(file, failed);
    if (failed)
        return false;
    const fs::path outside = fs::canonical(folder, failed);
    if (failed)
        return false;
    const auto [rest, end] =
        std::mismatch(outside.begin(), outside.end(), inside.begin(), inside.end());
    return rest == outside.end() && end != inside.end();
}

void check_virtual_raster(const fs::path& vrt) {
    try {
        Check().file(vrt, 0);
    } catch (const fs::filesystem_error& e) {
        throw util::Error(e.code().message());
    }
}

}  // namespace terravox::geo
