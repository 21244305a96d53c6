#include "voxelserver/out/export/vox/vox.hpp"

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/out/export/shape/placing.hpp"
#include "voxelserver/out/export/vox/vox_spool.hpp"

namespace terravox::exports {
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

std::string head_of(const char* id, std::uint64_t content, std::uint64_t children = 0) {
    return id + Content()
                    .number(static_cast<std::int32_t>(content))
                    .number(static_cast<std::int32_t>(children))
                    .bytes();
}
std::string chunk(const char* id, const Content& content) {
    return head_of(id, content.bytes().size()) + content.bytes();
}
constexpr std::uint64_t kHeadBytes = 12;
constexpr std::uint64_t kSizeBytes = 12;
std::uint64_t bytes_of(const VoxModel& m) {
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
    const voxel::MaterialTraits& traits = voxel::traits_of(m);
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
    to.put(head_of("XYZI", 4 + 4 * model.voxels));
    to.put_value(static_cast<std::int32_t>(model.voxels));
    for (const SpooledBox& box : model.boxes) {
        const auto place = [&](std::size_t a, std::uint8_t v) {
            return static_cast<std::uint8_t>(box.low[a] + v - model.min[a]);
        };
        spool.each(box, [&](const SpooledVoxel& v) {
            to.put_value(
                std::array<std::uint8_t, 4>{place(0, v.x), place(1, v.y), place(2, v.z),
                                            palette.index_of(v.material, v.colour, v.own)});
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
        bytes += bytes_of(model);
    if (bytes + 2 * kHeadBytes > most)
        fail();

    ByteFile out(file.temporary_path(), job.out.string());
    out.put("VOX ");
    out.put_value(kVersion);
    out.put(head_of("MAIN", 0, bytes));
    for (const VoxModel& model : spool.models())
        write_model(out, spool, model, palette);
    out.put(after);
    out.close();
    finish_file(job, file);
}

}  // namespace terravox::exports
