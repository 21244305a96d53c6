#include "voxelserver/data/imagery/orthophotos.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <list>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "common/geo/gdal.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/data/imagery/image_files.hpp"
#include "voxelserver/data/imagery/pixel_map.hpp"

namespace terravox::imagery {

namespace fs = std::filesystem;

struct Orthophotos::Layer {
    Image image;
    PixelMap map;
    double whole_pixel_m = 0;       ///< of the image itself
    long long pixel_mm = 0;         ///< of what is read of it, which may be an overview
    const voxel::Fingerprint file;  ///< its identity when it was opened
    voxel::Fingerprint identity;
    std::size_t series = 0;  ///< as in Input
    Image::Seen seen;        ///< of an image that does not state what its values mean
    Layer(const fs::path& path, const grid::Frame& frame, const grid::NamedSquare* square,
          const Layer* same, int windows)
        : image(path, square), map(frame, image), file(image_identity(path)), identity(file) {
        constexpr double kMax = 4096;
        if (same != nullptr && same->file != file)
            throw voxel::ChangedError("read the orthophoto " + path.string() +
                                      ": it has changed since it was opened; start again");
        if (same != nullptr)
            image.copy_brightness(same->image);
        else if (!image.states_brightness())
            seen = image.look_at_values(windows);
        whole_pixel_m = frame.voxel_m() / map.pixels_per_voxel();
        image.choose_overview(map.pixels_per_voxel());
        map = PixelMap(frame, image);
        pixel_mm = std::llround(1000 * frame.voxel_m() / map.pixels_per_voxel());
        if (!(map.pixels_per_voxel() <= kMax))
            throw util::Error(
                "read the orthophoto {}: {:f} pixels to a voxel's edge; allowed: up to 4096",
                path.string(), map.pixels_per_voxel());
        if (same != nullptr)
            return;
        if (image.placed_by_name())
            util::log_info(
                "orthophoto {}: not georeferenced; placed by its name on the square of {} (source "
                "{}, {}, E {:.0f} to {:.0f}, N {:.0f} to {:.0f})",
                path.string(), square->file, square->source, square->crs, square->west,
                square->east, square->south, square->north);
        else if (!image.crs())
            util::log_info("orthophoto {}: no CRS in the file; taken to be in {}", path.string(),
                           frame.crs().name());
    }

    /// Adds how the values are read to the identity: boxes depend on it, and it depends on the
    /// other images.
    void add_reading() {
        const BandRoles& roles = image.roles();
        voxel::ByteWriter out;
        out.add(identity);
        for (const int band : {roles.red, roles.green, roles.blue, roles.nir})
            out.add(band);
        image.add_brightness(out);
        identity = out.fingerprint();
    }
};

/// Limits the number of open files to what a process may have: the least recently used one is
/// closed. Guarded by gdal_mutex().
struct Orthophotos::OpenFiles {
    static constexpr std::size_t kMax = 256;
    std::list<Image*> used;  ///< most recently used first
    void use(Image& image) {
        const auto found = std::find(used.begin(), used.end(), &image);
        if (found != used.end())
            used.splice(used.begin(), used, found);
        else
            used.push_front(&image);
        if (used.size() > kMax) {
            used.back()->close();
            used.pop_back();
        }
    }
};

namespace {

/// Whether the image can still contribute to any column.
bool wanted(const Raster& raster, const ColumnRect& part, const ColumnRect& whole,
            std::uint8_t has) {
    if (raster.empty())
        return true;
    for (int z = part.z - whole.z; z < part.z - whole.z + part.height; ++z)
        for (int x = part.x - whole.x; x < part.x - whole.x + part.width; ++x)
            if ((raster.flags[static_cast<std::size_t>(z) * static_cast<std::size_t>(whole.width) +
                              static_cast<std::size_t>(x)] &
                 has) != has)
                return true;
    return false;
}

void allocate(Raster& raster, std::uint8_t has) {
    const auto count =
        static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height);
    raster.flags.resize(count);
    raster.colour.resize(count);
    raster.image.resize(count);
    if ((has & Raster::kNir) != 0) {
        raster.nir.resize(count);
        raster.red.resize(count);
    }
}

void put(Raster& raster, std::size_t at, const Pixel& p, std::uint8_t has, std::uint32_t image) {
    const auto news = static_cast<std::uint8_t>(has & ~raster.flags[at]);
    if ((news & Raster::kColour) != 0) {
        raster.colour[at] = {p.r, p.g, p.b};
        raster.image[at] = image;
    }
    if ((news & Raster::kNir) != 0) {
        raster.nir[at] = p.nir;
        raster.red[at] = p.r;
    }
    raster.flags[at] |= news;
}

/// Writes the values of one image for `part` into the raster of `whole`.
void fill(Raster& raster, const ColumnRect& whole, const ColumnPlaces& places, const Pixels& pixels,
          std::uint8_t has, std::uint32_t image) {
    for (int z = 0; z < places.rect.height; ++z)
        for (int x = 0; x < places.rect.width; ++x) {
            const auto from = static_cast<std::size_t>(z * places.rect.width + x);
            const auto row = static_cast<std::size_t>(places.rect.z - whole.z + z);
            const auto column = static_cast<std::size_t>(places.rect.x - whole.x + x);
            const std::size_t to = row * static_cast<std::size_t>(whole.width) + column;
            if (!raster.empty() && (raster.flags[to] & has) == has)
                continue;
            Pixel p;
            if (!mean_at(places, from, pixels, p))
                continue;
            allocate(raster, has);
            put(raster, to, p, has, image);
        }
}

/// A command that makes an image of 8 bits of one of other values. It takes them as the file stores
/// them.
/// @param white taken for it, with scale and offset
std::string describe_conversion(const Image& image, double white) {
    const double stored = image.stored(white);
    return fmt::format(
        "gdal_translate -ot Byte -scale {:g} WHITE 0 255 {} NEW.tif{}", image.stored(0),
        image.path().filename().string(),
        stored == white
            ? ""
            : fmt::format(", where WHITE is as the file stores it: {:g} for {:g}", stored, white));
}

/// Side of the blocks of columns that are read at once: limits their pixels to some 16 million.
int block_side(double pixels_per_voxel) {
    return static_cast<int>(std::clamp(4096 / pixels_per_voxel, 1.0, 256.0));
}

}  // namespace

Orthophotos::Orthophotos(const std::vector<fs::path>& paths, const grid::Frame& frame,
                         std::span<const grid::NamedSquare> squares, const Orthophotos* same)
    : m_frame(frame), m_open(std::make_unique<OpenFiles>()), m_same(same) {
    const std::lock_guard lock(gdal_mutex());
    geo::start_gdal();
    const std::vector<fs::path> files = same != nullptr ? same->order() : orthophoto_files(paths);
    // Windows along an edge of each image that must be looked at: a few hundred in all.
    constexpr double kWindows = 256;
    const double share =
        std::sqrt(kWindows / static_cast<double>(std::max<std::size_t>(files.size(), 1)));
    const int windows = static_cast<int>(std::clamp(share, 1.0, 4.0));
    for (const fs::path& file : files) {
        const auto square =
            std::find_if(squares.begin(), squares.end(),
                         [&](const grid::NamedSquare& s) { return grid::is_named_like(file, s); });
        m_layers.push_back(std::make_unique<Layer>(
            file, m_frame, square == squares.end() ? nullptr : &*square,
            same != nullptr ? same->m_layers[m_layers.size()].get() : nullptr, windows));
        m_open->use(m_layers.back()->image);
    }
    std::sort(m_layers.begin(), m_layers.end(), [](const auto& a, const auto& b) {
        if (a->pixel_mm != b->pixel_mm)
            return a->pixel_mm < b->pixel_mm;
        if (a->image.date() != b->image.date())
            return a->image.date() > b->image.date();
        const std::string name_a = a->image.path().filename().string();
        const std::string name_b = b->image.path().filename().string();
        return name_a != name_b ? name_a < name_b : a->image.path() < b->image.path();
    });
    find_series();
    if (m_same == nullptr) {
        judge_scales();
        assume(true);
        assume(false);
        std::set<std::string> doubts;
        for (const auto& layer : m_layers)
            doubts.insert(layer->image.roles().doubt);
        doubts.erase("");
        for (const std::string& doubt : doubts)
            warn_of_some(doubt,
                         [&](const Layer& layer) { return layer.image.roles().doubt == doubt; });
    }
    for (const auto& layer : m_layers)
        layer->add_reading();
}

// A scale to radiance or the like says nothing of what is white. Decided for all images of a scale:
// most tiles of a flight are too dark to tell.
void Orthophotos::judge_scales() {
    std::map<std::vector<Image::Scale>, double> brightest;
    for (const auto& layer : m_layers) {
        double& high = brightest[layer->image.scales()];
        high = std::max(high, layer->seen.scaled.high);
    }
    for (const auto& layer : m_layers)
        if (brightest[layer->image.scales()] > kMostReflectance)
            layer->image.forget_scales();
}

// One scale for all images whose values are of one sort: tiles of one flight must fit together.
void Orthophotos::assume(bool whole_numbers) {
    ValueRange range;
    const Layer* brightest = nullptr;
    std::size_t count = 0;
    const auto is_concerned = [&](const Layer& layer) {
        return !layer.image.states_brightness() && layer.image.has_whole_numbers() == whole_numbers;
    };
    double high = 0;
    for (const auto& layer : m_layers) {
        if (!is_concerned(*layer))
            continue;
        ++count;
        const bool is_scaled = !layer->image.scales().empty();
        const ValueRange& own = is_scaled ? layer->seen.scaled : layer->seen.stored;
        if (brightest == nullptr || own.high > high) {
            brightest = layer.get();
            high = own.high;
        }
        range.add(own);
    }
    if (brightest == nullptr)
        return;
    const Assumption found = assume_brightness(range, whole_numbers);
    for (const auto& layer : m_layers)
        if (is_concerned(*layer))
            layer->image.set_brightness(found.brightness);
    util::log_message(found.is_doubtful ? util::LogLevel::kWarning : util::LogLevel::kInfo,
                      "orthophoto {}{}: values from {:g} to {:g} are taken for {}: {:g} is white{}",
                      brightest->image.path().string(),
                      count > 1 ? fmt::format(" and {} more", count - 1) : "", range.low,
                      range.high, found.what, found.white,
                      found.is_doubtful ? "; if another value is, make images of 8 bits: " +
                                              describe_conversion(brightest->image, found.white)
                                        : "");
}

/// @param is_such  of which images it is true
template <class Test>
void Orthophotos::warn_of_some(std::string_view what, const Test& is_such) const {
    const auto test = [&](const auto& layer) { return is_such(*layer); };
    const auto shown = std::find_if(m_layers.begin(), m_layers.end(), test);
    const auto count = std::count_if(m_layers.begin(), m_layers.end(), test);
    if (count > 0)
        util::log_warn("orthophoto {}{}: {}", (*shown)->image.path().string(),
                       count > 1 ? fmt::format(" (one of {} such)", count) : "", what);
}

void Orthophotos::find_series() {
    constexpr double kSameSize = 1.1;
    constexpr std::size_t kYear = 4;  // characters of a date
    std::vector<Layer*> finest_first;
    for (const auto& layer : m_layers)
        finest_first.push_back(layer.get());
    std::stable_sort(finest_first.begin(), finest_first.end(), [](const Layer* a, const Layer* b) {
        return a->whole_pixel_m < b->whole_pixel_m;
    });
    std::map<std::pair<double, std::string>, std::size_t> series;
    double finest_m = 0;  // of those whose pixels have about one size
    for (Layer* const layer : finest_first) {
        if (layer->whole_pixel_m > kSameSize * finest_m)
            finest_m = layer->whole_pixel_m;
        const std::pair key{finest_m, layer->image.date().substr(0, kYear)};
        layer->series = series.emplace(key, series.size()).first->second;
    }
}

Orthophotos::~Orthophotos() {
    const std::lock_guard lock(gdal_mutex());
    if (m_same == nullptr)
        warn_of_some("all of it that was read is black",
                     [](const Layer& layer) { return layer.image.is_black(); });
    else
        for (const auto& layer : m_layers)
            m_same->add_read(layer->image);
    m_layers.clear();
}

void Orthophotos::add_read(const Image& image) const {
    const auto here = std::find_if(m_layers.begin(), m_layers.end(), [&](const auto& layer) {
        return layer->image.path() == image.path();
    });
    if (here != m_layers.end())
        (*here)->image.add_read(image);
}

void Orthophotos::warn_of_outside(const grid::ColumnRect& world) const {
    const Layer* shown = nullptr;
    std::size_t outside = 0;
    for (const auto& layer : m_layers) {
        const PixelMap::Extent& e = layer->map.extent();
        const bool apart = e.x1 <= world.min_x || e.x0 >= world.max_x || e.z1 <= world.min_z ||
                           e.z0 >= world.max_z;
        if (!apart)
            continue;
        ++outside;
        if (shown == nullptr || (shown->image.crs() && !layer->image.crs()))
            shown = layer.get();  // one whose CRS was assumed is the most informative
    }
    if (shown == nullptr)
        return;
    const auto place = [&](double x0, double z0, double x1, double z1) {
        return fmt::format("E {:.0f} to {:.0f}, N {:.0f} to {:.0f}", m_frame.easting(x0),
                           m_frame.easting(x1), m_frame.northing(z1), m_frame.northing(z0));
    };
    const PixelMap::Extent& e = shown->map.extent();
    const bool suspicious = outside == m_layers.size() || !shown->image.crs();
    util::log_message(
        suspicious ? util::LogLevel::kWarning : util::LogLevel::kInfo,
        "orthophoto {}{} covers nothing of the world: it lies at {} ({}{}), the world at {}",
        shown->image.path().string(), outside > 1 ? fmt::format(" (one of {} such)", outside) : "",
        place(e.x0, e.z0, e.x1, e.z1), m_frame.crs().name(),
        shown->image.crs() ? "" : ", assumed: the file names no CRS",
        place(world.min_x, world.min_z, world.max_x, world.max_z));
}

std::size_t Orthophotos::count() const noexcept {
    return m_layers.size();
}

std::vector<fs::path> Orthophotos::order() const {
    std::vector<fs::path> out;
    for (const auto& layer : m_layers)
        out.push_back(layer->image.path());
    return out;
}

std::vector<Orthophotos::Input> Orthophotos::inputs() const {
    std::vector<Input> out;
    for (const auto& layer : m_layers)
        out.push_back({layer->map.influence(), layer->identity, layer->series});
    return out;
}

void Orthophotos::add_layer(std::size_t index, const ColumnRect& whole, Raster& raster) const {
    Layer& layer = *m_layers[index];
    const ColumnRect covered = layer.map.covered(whole);
    const int side = block_side(layer.map.pixels_per_voxel());
    const BandRoles& roles = layer.image.roles();
    const auto has = static_cast<std::uint8_t>((roles.colour() ? Raster::kColour : 0) |
                                               (roles.nir != 0 ? Raster::kNir : 0));
    Pixels pixels;
    for (int z = 0; z < covered.height; z += side)
        for (int x = 0; x < covered.width; x += side) {
            const ColumnRect part{covered.x + x, covered.z + z, std::min(side, covered.width - x),
                                  std::min(side, covered.height - z)};
            if (!wanted(raster, part, whole, has))
                continue;
            ColumnPlaces places;
            {
                const std::lock_guard lock(gdal_mutex());
                places = find_places(layer.map, part);
                const PixelWindow window =
                    find_window(places, layer.image.width(), layer.image.height());
                if (window.width < 1)
                    continue;
                m_open->use(layer.image);
                layer.image.read(window, pixels);
            }
            fill(raster, whole, places, pixels, has, static_cast<std::uint32_t>(index));
        }
}

Raster Orthophotos::read(std::int32_t x0, std::int32_t z0, int width, int height) const {
    constexpr int kMaxColumns = 65536;
    if (width < 1 || height < 1 || width > kMaxColumns || height > kMaxColumns)
        throw util::Error("read orthophotos: {} x {} columns; allowed: 1 to 65536 each", width,
                          height);
    Raster raster;
    raster.width = width;
    raster.height = height;
    for (std::size_t i = 0; i < m_layers.size(); ++i)
        add_layer(i, {x0, z0, width, height}, raster);
    return raster;
}

Raster Orthophotos::read_image(std::size_t image, const ColumnRect& rect) const {
    Raster raster;
    raster.width = rect.width;
    raster.height = rect.height;
    add_layer(image, rect, raster);
    return raster;
}

}  // namespace terravox::imagery
