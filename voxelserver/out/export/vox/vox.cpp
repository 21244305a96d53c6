#include "voxelserver/out/export/vox/vox.hpp"

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>

#include "common/thread/in_order.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

namespace terravox::exports {
namespace {

// A model is at most 256 wide, and a box as high as that.
constexpr std::size_t kModelEdge = 256 / voxel::kBoxSizeX;

}  // namespace

VoxSpool::VoxSpool(Job& job, VoxPalette& palette, std::uint64_t max_voxels,
                   const std::function<void()>& fail_too_many)
    : m_file(ByteFile::spool_for(job.out)) {
    const Columns columns = job.columns(kModelEdge);
    std::size_t square = 0;
    thread::in_order(
        columns.count(), job.threads,
        [&](std::size_t i) { return make_column(job, columns.at(i)); },
        [&](std::size_t i, const std::vector<MadeBox>& made) {
            if (const std::size_t now = columns.at(i).square; now != square) {
                end_square();
                square = now;
            }
            for (const MadeBox& m : made) {
                SpooledBox box = m.box;
                box.first = m_voxels;
                box.count = m.voxels.size();
                m_voxels += box.count;
                if (m_voxels > max_voxels)
                    fail_too_many();
                m_file.put(std::as_bytes(std::span(m.voxels)));
                for (const SpooledVoxel& v : m.voxels)
                    palette.count(v.material, v.colour, v.own);
                m_square[m.by].boxes.push_back(box);
                job.count_voxels(box.count);
            }
            job.meter.add();
        });
    end_square();
}

std::vector<VoxSpool::MadeBox> VoxSpool::make_column(Job& job, const Columns::At& at) {
    std::vector<MadeBox> out;
    const auto origin = make_origin(job.part);
    const voxel::ColumnExtent extent = job.column(at.bx, at.bz);
    for (std::int32_t by = extent.by_begin; by < extent.by_end; ++by) {
        const auto box = job.box(at.bx, by, at.bz);
        if (!box)
            continue;
        const std::int32_t x0 = at.bx * voxel::kBoxSizeX;
        const std::int32_t y0 = by * voxel::kBoxSizeY;
        const std::int32_t z0 = at.bz * voxel::kBoxSizeZ;
        MadeBox made;
        made.by = by;
        // North is up in the file: its y falls as z rises.
        made.box.low = {x0 - origin[0], origin[2] - z0 - voxel::kBoxSizeZ, y0 - origin[1]};
        made.box.min = {255, 255, 255};
        each_voxel(
            *box,
            [&](int x, int y, int z, const voxel::VoxelAttr& attr) {
                if (!job.part.holds(x0 + x, y0 + y, z0 + z))
                    return;
                const std::array<std::uint8_t, 3> p = {
                    static_cast<std::uint8_t>(x),
                    static_cast<std::uint8_t>(voxel::kBoxSizeZ - 1 - z),
                    static_cast<std::uint8_t>(y)};
                for (std::size_t a = 0; a < 3; ++a) {
                    made.box.min[a] = std::min(made.box.min[a], p[a]);
                    made.box.max[a] = std::max(made.box.max[a], p[a]);
                }
                made.voxels.push_back({p[0], p[1], p[2], attr.material, job.to_colour(attr),
                                       attr.has_colour() && job.colours == Colours::kTrue});
            },
            [](int, int, int, int) {});
        if (!made.voxels.empty())
            out.push_back(std::move(made));
    }
    return out;
}

void VoxSpool::end_square() {
    for (auto& [by, model] : m_square) {
        std::array<std::int32_t, 3> min{};
        std::array<std::int32_t, 3> max{};
        for (std::size_t i = 0; i < model.boxes.size(); ++i) {
            const SpooledBox& box = model.boxes[i];
            model.voxels += box.count;
            for (std::size_t a = 0; a < 3; ++a) {
                const std::int32_t lo = box.low[a] + box.min[a];
                const std::int32_t hi = box.low[a] + box.max[a];
                min[a] = i == 0 ? lo : std::min(min[a], lo);
                max[a] = i == 0 ? hi : std::max(max[a], hi);
            }
        }
        model.min = min;
        for (std::size_t a = 0; a < 3; ++a)
            model.size[a] = max[a] - min[a] + 1;
        m_models.push_back(std::move(model));
    }
    m_square.clear();
}

void VoxSpool::each(const SpooledBox& box, const std::function<void(const SpooledVoxel&)>& use) {
    std::vector<SpooledVoxel> piece(1 << 14);
    for (std::uint64_t done = 0; done < box.count; done += piece.size()) {
        const auto part = std::span(piece).first(
            static_cast<std::size_t>(std::min<std::uint64_t>(piece.size(), box.count - done)));
        m_file.read((box.first + done) * sizeof(SpooledVoxel), std::as_writable_bytes(part));
        for (const SpooledVoxel& v : part)
            use(v);
    }
}

namespace {

using voxel::Material;
using Texts = std::initializer_list<std::pair<std::string, std::string>>;
constexpr std::uint32_t kVersion = 200;
constexpr std::array<std::int64_t, 3> kMaxShown = {2000, 2000, 1000};

/// The content of a chunk, appended value by value.
/// Ref: ephtracy, "MagicaVoxel .vox File Format" and its extension, 2016 on.
class Content {
public:
    Content& number(std::int32_t v) {
        return m_bytes.append(reinterpret_cast<const char*>(&v), sizeof v), *this;
    }
    Content& text(const std::string& t) {
        return number(static_cast<std::int32_t>(t.size())), m_bytes += t, *this;
    }
    Content& dict(Texts pairs) {
        number(static_cast<std::int32_t>(pairs.size()));
        for (const auto& [key, value] : pairs)
            text(key).text(value);
        return *this;
    }
    Content& raw(const std::string& bytes) { return m_bytes += bytes, *this; }
    [[nodiscard]] const std::string& bytes() const noexcept { return m_bytes; }

private:
    std::string m_bytes;
};

std::string make_head(const char* id, std::uint64_t content, std::uint64_t children = 0) {
    return id + Content()
                    .number(static_cast<std::int32_t>(content))
                    .number(static_cast<std::int32_t>(children))
                    .bytes();
}
std::string chunk(const char* id, const Content& content) {
    return make_head(id, content.bytes().size()) + content.bytes();
}
constexpr std::uint64_t kHeadBytes = 12;
constexpr std::uint64_t kSizeBytes = 12;
std::uint64_t measure_bytes(const VoxModel& m) {
    return kHeadBytes + kSizeBytes + kHeadBytes + 4 + 4 * m.voxels;
}

// Root, a group, and for each model a transform and a shape. A model is placed by its middle,
// rounded down.
std::string scene_graph(const std::vector<VoxModel>& models) {
    const auto transform = [](std::int32_t id, std::int32_t child, std::int32_t layer,
                              const std::string& place) {
        Content c;
        c.number(id).dict({}).number(child).number(-1).number(layer).number(1);
        return chunk("nTRN", place.empty() ? c.dict({}) : c.dict({{"_t", place}}));
    };
    Content group;
    group.number(1).dict({}).number(static_cast<std::int32_t>(models.size()));
    std::string nodes;
    for (std::size_t i = 0; i < models.size(); ++i) {
        const VoxModel& m = models[i];
        const auto id = static_cast<std::int32_t>(2 + 2 * i);
        std::string place;
        for (std::size_t a = 0; a < 3; ++a)
            place += (a == 0 ? "" : " ") + std::to_string(m.min[a] + m.size[a] / 2);
        group.number(id);
        nodes += transform(id, id + 1, 0, place);
        nodes += chunk("nSHP", Content()
                                   .number(id + 1)
                                   .dict({})
                                   .number(1)
                                   .number(static_cast<std::int32_t>(i))
                                   .dict({}));
    }
    return transform(0, 1, -1, "") + chunk("nGRP", group) + nodes;
}

std::string colours_chunk(const std::vector<VoxColour>& colours) {
    constexpr std::size_t kEntries = 256;
    std::string rgba;
    for (std::size_t i = 0; i < kEntries; ++i) {
        const voxel::Rgb8 c =
            i < colours.size() ? colours[i].colour : voxel::Rgb8{0x4B, 0x4B, 0x4B};
        for (const std::uint8_t v : {c.r, c.g, c.b, std::uint8_t{255}})
            rgba += static_cast<char>(v);
    }
    return chunk("RGBA", Content().raw(rgba));
}

// MagicaVoxel's material of a colour of a special material. Older versions use _weight, newer ones
// _alpha and _trans.
std::string material_chunk(std::int32_t index, Material m) {
    const auto glass = [&](const char* clear, const char* rough, const char* bends,
                           const char* index_of_refraction, const char* dims) {
        return chunk("MATL", Content().number(index).dict({{"_type", "_glass"},
                                                           {"_weight", clear},
                                                           {"_alpha", clear},
                                                           {"_trans", clear},
                                                           {"_rough", rough},
                                                           {"_ior", bends},
                                                           {"_ri", index_of_refraction},
                                                           {"_att", dims}}));
    };
    const voxel::MaterialTraits& traits = voxel::find_traits(m);
    if (traits.glow > 0)
        return chunk("MATL",
                     Content().number(index).dict({{"_type", "_emit"},
                                                   {"_weight", "1"},
                                                   {"_emit", "1"},
                                                   {"_flux", std::to_string(traits.glow)}}));
    switch (traits.optics) {
        case voxel::Optics::kWater: return glass("0.6", "0.05", "0.333", "1.333", "0.1");
        case voxel::Optics::kGlass: return glass("0.9", "0", "0.5", "1.5", "0");
        case voxel::Optics::kIce: return glass("0.5", "0.1", "0.31", "1.31", "0.2");
        default: return {};
    }
}

void warn_if_too_wide(const Job& job) {
    const auto size = [&](std::size_t axis) {
        return std::int64_t{job.part.bounds.max[axis]} - job.part.bounds.min[axis];
    };
    if (size(0) > kMaxShown[0] || size(2) > kMaxShown[1] || size(1) > kMaxShown[2])
        util::log_warn(
            "{}: {} x {} x {} voxels (height last); MagicaVoxel itself shows no more than {} x {} "
            "x {}",
            job.out.string(), size(0), size(2), size(1), kMaxShown[0], kMaxShown[1], kMaxShown[2]);
}

void write_model(ByteFile& to, VoxSpool& spool, const VoxModel& model, const VoxPalette& palette) {
    to.put(
        chunk("SIZE", Content().number(model.size[0]).number(model.size[1]).number(model.size[2])));
    to.put(make_head("XYZI", 4 + 4 * model.voxels));
    to.put_value(static_cast<std::int32_t>(model.voxels));
    for (const SpooledBox& box : model.boxes) {
        const auto place = [&](std::size_t a, std::uint8_t v) {
            return static_cast<std::uint8_t>(box.low[a] + v - model.min[a]);
        };
        spool.each(box, [&](const SpooledVoxel& v) {
            to.put_value(
                std::array<std::uint8_t, 4>{place(0, v.x), place(1, v.y), place(2, v.z),
                                            palette.compute_index(v.material, v.colour, v.own)});
        });
    }
}

}  // namespace

void write_vox(Job& job, const VoxOptions& options) {
    const std::uint64_t most =
        std::min<std::uint64_t>(options.max_bytes, std::numeric_limits<std::int32_t>::max());
    const auto fail = [&] {
        throw util::Error("write " + job.out.string() + ": more than " + std::to_string(most) +
                          " bytes, the most that the format allows (some " +
                          std::to_string(most / 4) +
                          " voxels); nothing was written (smaller: a part, or a coarser level)");
    };
    util::AtomicFile file(job.out);
    warn_if_too_wide(job);
    VoxPalette palette(job.palette);
    VoxSpool spool(job, palette, most / 4, fail);
    if (spool.models().empty())
        fail_for_nothing(job);
    const auto colours = palette.choose();
    std::string after = scene_graph(spool.models()) + colours_chunk(colours);
    for (std::size_t i = 0; i < colours.size(); ++i)
        after += material_chunk(static_cast<std::int32_t>(i + 1), colours[i].material);
    std::uint64_t bytes = after.size();
    for (const VoxModel& model : spool.models())
        bytes += measure_bytes(model);
    if (bytes + 2 * kHeadBytes > most)
        fail();

    ByteFile out(file.temporary_path(), job.out.string());
    out.put("VOX ");
    out.put_value(kVersion);
    out.put(make_head("MAIN", 0, bytes));
    for (const VoxModel& model : spool.models())
        write_model(out, spool, model, palette);
    out.put(after);
    out.close();
    finish_file(job, file);
}

const Format kVoxFormat{
    .name = "vox",
    .extension = ".vox",
    .check_target = check_file_target,
    .steps = column_steps,
    .write = [](Job& job, const WriteOptions& /*options*/) { write_vox(job); },
};

}  // namespace terravox::exports
