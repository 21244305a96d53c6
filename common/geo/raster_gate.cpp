#include "common/geo/raster_gate.hpp"

#include <cpl_conv.h>
#include <cpl_minixml.h>
#include <gdal_frmts.h>
#include <gdal_priv.h>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/text.hpp"

namespace terravox::geo {
namespace {

std::string upper(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

}  // namespace

std::vector<std::filesystem::path> side_files(const std::filesystem::path& raster) {
    std::vector<std::string> endings{".wld", ".prj", ".tab", ".hdr"};
    // The extension of a world file is the raster's first and last letter, or all of it, followed
    // by a w.
    if (const std::string own = util::lower_extension(raster); own.size() > 2) {
        endings.push_back(own + "w");
        endings.push_back({'.', own[1], own.back(), 'w'});
    }
    std::vector<std::filesystem::path> out;
    for (const std::string& ending : endings)
        for (const std::string& any_case : {ending, upper(ending)})
            out.push_back(std::filesystem::path(raster).replace_extension(any_case));
    for (const char* ending : {".aux.xml", ".hdr", ".HDR", ".ovr", ".OVR", ".msk", ".MSK"})
        out.push_back(std::filesystem::path(raster) += ending);
    return out;
}

namespace {

// As isspace() of the C locale, without its call for each byte.
bool is_space(char c) noexcept {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

constexpr std::size_t kLongestNumber = 64;

/// As GDAL reads them: a comma may stand for the point, and "1.#QNAN" for no number.
bool is_number(std::string_view word) {
    if (word.find_first_not_of("+-.,0123456789eE") == std::string_view::npos)
        return word.find_first_of("0123456789") != std::string_view::npos;
    word.remove_prefix(word.front() == '-' || word.front() == '+' ? 1 : 0);
    const std::string name = util::lower_case(word);
    return name == "nan" || name == "inf" || name == "infinity" || name.starts_with("1.#");
}

/// The lines before the values: each a name and a number.
class HeaderOfGrid {
public:
    /// @return whether the next word is one of the header
    bool takes(std::string_view word) {
        if (m_has_ended)
            return false;
        m_is_name = !m_is_name;
        const bool is_letter = std::isalpha(static_cast<unsigned char>(word.front())) != 0;
        m_has_ended = m_is_name && (!is_letter || is_number(word));
        return !m_has_ended;
    }

private:
    bool m_is_name = false;
    bool m_has_ended = false;
};

}  // namespace

std::optional<std::string> find_fault_of_grid(const std::filesystem::path& file,
                                              std::uint64_t values) {
    constexpr std::size_t kBlock_bytes = std::size_t{1} << 20;
    std::ifstream in(file, std::ios::binary);
    std::vector<char> block(kBlock_bytes);
    std::uint64_t found = 0;
    std::string word;
    HeaderOfGrid header;
    while (in && found < values) {
        in.read(block.data(), static_cast<std::streamsize>(block.size()));
        auto count = static_cast<std::size_t>(in.gcount());
        if (count < block.size())
            block[count++] = ' ';  // behind the last value
        for (std::size_t i = 0; i < count && found < values; ++i) {
            if (!is_space(block[i])) {
                if (word.size() < kLongestNumber)
                    word += block[i];
                continue;
            }
            const bool is_value = !word.empty() && !header.takes(word);
            if (is_value && !is_number(word))
                return "its value '" + util::printable(word) +
                       "' is no number; write one for no data, which the line NODATA_value names";
            found += is_value ? 1U : 0U;
            word.clear();
        }
    }
    if (found == values)
        return std::nullopt;
    if (!in.eof())
        throw util::Error("read {} to its end: it cannot be read", file.string());
    return "cut short: it has fewer than the " + std::to_string(values) +
           " values that its header states";
}

namespace fs = std::filesystem;

const char* const kRasterDrivers[] = {"GTiff",   "JPEG", "PNG",  "JP2OpenJPEG", "VRT",
                                      "AAIGrid", "EHdr", "ENVI", "SRTMHGT",     "USGSDEM",
                                      "DTED",    "XYZ",  nullptr};

namespace {

using OpenRaster = GDALDataset* (*)(GDALOpenInfo*);

/// The drivers' original functions, which the gate calls. Written once, before any raster is
/// opened.
std::vector<std::pair<GDALDriver*, OpenRaster>>& originals() {
    static std::vector<std::pair<GDALDriver*, OpenRaster>> all;
    return all;
}

OpenRaster find_original(const GDALDriver* driver) {
    for (const auto& [known, open] : originals())
        if (known == driver)
            return open;
    return nullptr;
}

void check_crs_texts(const CPLXMLNode* node) {
    for (; node != nullptr; node = node->psNext) {
        check_crs_texts(node->psChild);
        if (node->eType != CXT_Element && node->eType != CXT_Attribute)
            continue;
        // All keys under which GDAL's and Esri's .aux.xml define a system.
        const std::string_view name = node->pszValue;
        const bool names_crs = EQUAL(name.data(), "SRS") || EQUAL(name.data(), "WKT") ||
                               EQUAL(name.data(), "Projection");
        const std::string text = names_crs ? CPLGetXMLValue(node, nullptr, "") : "";
        if (text.empty())
            continue;
        if (const std::string fault = fault_of_crs_text(text); !fault.empty())
            throw util::Error("the coordinate reference system of its .aux.xml: " + fault);
    }
}

std::string to_text(const fs::path& file) {
    constexpr std::size_t kMax_bytes = std::size_t{64} << 20;
    return util::read_text(file, kMax_bytes, "its side file " + file.filename().string());
}

void check_aux_xml(const fs::path& file) {
    const std::string text = to_text(file);
    // Text that this parser rejects is rejected by GDAL, too, which uses the same parser.
    const std::unique_ptr<CPLXMLNode, decltype(&CPLDestroyXMLNode)> tree(
        CPLParseXMLString(text.c_str()), &CPLDestroyXMLNode);
    check_crs_texts(tree.get());
}

/// WKT within other text: while reading it, PROJ opens only files named by these two; the rest is
/// checked after it was read (Crs::from_ogr).
void check_for_grids(const fs::path& file) {
    std::string text = to_text(file);
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    for (const char* const word : {"PROJ4_GRIDS", "PARAMETERFILE"})
        if (text.find(word) != std::string::npos)
            throw util::Error("its side file {} names files ({})", file.filename().string(), word);
}

void check_side_files(const fs::path& raster) {
    const fs::path folder = raster.parent_path();
    const fs::path own = fs::canonical(raster).parent_path();
    for (const fs::path& side : side_files(raster)) {
        std::error_code failed;
        if (!fs::exists(fs::symlink_status(side, failed)))
            continue;
        const bool stays = lies_in(side, folder) || lies_in(side, own);
        if (!fs::is_regular_file(side, failed) || !stays)
            throw util::Error("its side file {} is no file next to or below it",
                              side.filename().string());
        const std::string ending = side.extension().string();
        if (ending == ".xml")
            check_aux_xml(side);
        if (EQUAL(ending.c_str(), ".prj") || EQUAL(ending.c_str(), ".hdr"))
            check_for_grids(side);
    }
}

void check_before(GDALDriver& driver, const fs::path& raster, GDALAccess access) {
    check_side_files(raster);
    // Checked here, so that sources of a mosaic and overviews in separate files are included. A
    // file that is open for writing is not complete yet.
    if (EQUAL(driver.GetDescription(), "GTiff") && access == GA_ReadOnly) {
        if (const auto lost = find_lost_directory_of_tiff(raster))
            throw util::Error("cut short: " + *lost);
    }
    if (!EQUAL(driver.GetDescription(), "VRT"))
        return;
    if (!EQUAL(raster.extension().c_str(), ".vrt"))
        throw util::Error("a virtual raster that is not named .vrt");
    check_virtual_raster(raster);
}

/// Whether the values of an Esri ASCII grid begin with "nan". GDAL (3.6, at least) takes the line
/// for one of the header, and moves all others up.
bool begins_with_nan(const fs::path& grid) {
    constexpr int kLongest = 64;
    std::ifstream in(grid);
    std::string word;
    while (in >> std::setw(kLongest) >> word) {
        if (EQUAL(word.c_str(), "nan") || EQUAL(word.c_str(), "-nan"))
            return true;
        if (std::isalpha(static_cast<unsigned char>(word.front())) == 0)
            return false;
        in >> std::setw(kLongest) >> word;  // the value of a word of the header
    }
    return false;
}

/// @param data null where GDAL cannot open it
void check_nan_of_grid(GDALDataset* data, const fs::path& grid) {
    if (!begins_with_nan(grid))
        return;
    double first = 0;
    if (data != nullptr &&
        data->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, 1, 1, &first, 1, 1, GDT_Float64, 0, 0,
                                         nullptr) == CE_None &&
        std::isnan(first))
        return;
    throw util::Error(
        "its first value is nan, which GDAL {} takes for a word of the header; write a number for "
        "no data, which the line NODATA_value names: sed -E 's/-?nan/-9999/Ig' {} > NEW.asc",
        GDALVersionInfo("RELEASE_NAME"), grid.filename().string());
}

void check_opened(const GDALDriver& driver, GDALDataset& data, const fs::path& raster) {
    if (EQUAL(driver.GetDescription(), "AAIGrid")) {
        const auto values = static_cast<std::uint64_t>(data.GetRasterXSize()) *
                            static_cast<std::uint64_t>(data.GetRasterYSize());
        if (const auto fault = find_fault_of_grid(raster, values))
            throw util::Error(*fault);
    }
    if (data.GetMetadataItem("OVERVIEW_FILE", "OVERVIEWS") != nullptr)
        throw util::Error("its metadata name another file for its overviews");
    if (data.GetMetadata("GEOLOCATION") != nullptr)
        throw util::Error("its metadata name other files for its geolocation");
}

/// A callback of GDAL. A file that the driver itself does not recognise is reported as such, so
/// that GDAL tries other drivers.
GDALDataset* open_through_gate(GDALDriver* driver, GDALOpenInfo* info) noexcept {
    try {
        if (driver->pfnIdentify != nullptr && driver->pfnIdentify(info) == 0)
            return nullptr;
        // GDAL's in-memory files: parts of a file that it has open (JPEG in TIFF), and files that
        // this program makes. No untrusted text is opened this way.
        const bool is_virtual = std::string_view(info->pszFilename).starts_with("/vsi");
        if (is_virtual && EQUAL(driver->GetDescription(), "VRT"))
            throw util::Error("a virtual raster that is no file");
        std::error_code failed;
        // GDAL also calls this for files that it is about to write: a missing file is not an error.
        if (!is_virtual && !fs::is_regular_file(info->pszFilename, failed))
            return nullptr;
        if (!is_virtual)
            check_before(*driver, info->pszFilename, info->eAccess);
        std::unique_ptr<GDALDataset> data(find_original(driver)(info));
        if (!is_virtual && EQUAL(driver->GetDescription(), "AAIGrid"))
            check_nan_of_grid(data.get(), info->pszFilename);
        if (data && !is_virtual)
            check_opened(*driver, *data, info->pszFilename);
        return data.release();
    } catch (const std::exception& e) {
        CPLError(CE_Failure, CPLE_OpenFailed, "%s", e.what());
    }
    return nullptr;
}

}  // namespace

void register_raster_drivers() {
    GDALRegister_VRT();
    GDALRegister_GTiff();
    GDALRegister_COG();
    GDALRegister_JPEG();
    GDALRegister_PNG();
    GDALRegister_JP2OpenJPEG();
    GDALRegister_AAIGrid();
    GDALRegister_DTED();
    GDALRegister_SRTMHGT();
    GDALRegister_USGSDEM();
    GDALRegister_XYZ();
    GDALRegister_ENVI();
    GDALRegister_EHdr();
    GDALRegister_MEM();
    for (const char* const* name = kRasterDrivers; *name != nullptr; ++name) {
        GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName(*name);
        if (driver == nullptr || driver->pfnOpen == nullptr)
            continue;
        originals().emplace_back(driver, driver->pfnOpen);
        driver->pfnOpen = nullptr;
        driver->pfnOpenWithDriverArg = open_through_gate;
    }
    // The MEM driver is used for writing only, never for opening: its names are addresses in this
    // process.
    if (GDALDriver* const memory = GetGDALDriverManager()->GetDriverByName("MEM"))
        memory->pfnOpen = nullptr;
    CPLSetConfigOption("GDAL_VRT_ENABLE_PYTHON", "NO");
    CPLSetConfigOption("GDAL_VRT_ENABLE_RAWRASTERBAND", "NO");
    CPLSetConfigOption("CPL_VSIL_CURL_ALLOWED_FILENAME", "none");
}

}  // namespace terravox::geo
