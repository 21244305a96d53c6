#include "voxelserver/make/worlds/open/open_served_world.hpp"

#include <atomic>
#include <random>
#include <type_traits>
#include <utility>

#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/fingerprint.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

namespace terravox::worlds {
namespace {

using voxel::Fingerprint;

/// Names what is left out on purpose.
template <class... Members>
void unused(const Members&... /*members*/) {}

/// Adds all options that boxes depend on. A member that is missing in one of the two bindings is an
/// error of the compiler, so that no new option is forgotten.
void add_options(voxel::ByteWriter& out, const WorldOptions& options) {
    const auto& [inputs, left_out, orthophotos, additions, plane, title, crs, classes, mark_unknown,
                 vertical_unit, settings, steps, photo, voxel_m, dimension, base_m, generated,
                 known_squares, chunk_indices, reads_chunk_indices, memory_bytes, threads,
                 cache_dir, cache_bytes, box_timeout] = options;
    const auto& [seed, water_level, world_height, harmonics, frequency, smoothness,
                 generated_voxel_m, trees] = generated;
    out.add(static_cast<std::uint64_t>(inputs.size()));
    for (const std::string& input : inputs)
        out.add(input);
    out.add(static_cast<std::uint64_t>(orthophotos.size()));
    for (const auto& image : orthophotos)
        out.add(image.string());
    for (const std::string& addition : additions)
        out.add(addition);
    out.add(crs);
    out.add(vertical_unit);
    out.add(voxel_m);
    out.add(dimension);
    out.add(base_m.has_value());
    out.add(base_m.value_or(0));
    out.add(seed);
    out.add(water_level);
    out.add(world_height);
    out.add(harmonics);
    out.add(frequency);
    out.add(smoothness);
    out.add(trees);
    // Those of LiDAR data (InputFingerprints has them), and those that no box depends on; the size
    // of generated voxels is voxel_m.
    unused(left_out, plane, title, classes, mark_unknown, settings, steps, photo, generated_voxel_m,
           known_squares, chunk_indices, reads_chunk_indices, memory_bytes, threads, cache_dir,
           cache_bytes, box_timeout);
}

Fingerprint random_fingerprint() {
    std::random_device device;
    const auto word = [&] { return std::uint64_t{device()} << 32 | device(); };
    const std::uint64_t first = word();
    return {first, word()};
}

/// A world whose boxes all depend on all of its inputs.
class WholeWorld final : public ServedWorld {
public:
    WholeWorld(const ServeRequest& request, const WorldKind& kind, util::StageTimes& times,
               const std::stop_token& stop)
        : m_options(request.options),
          m_kind(kind),
          m_files_before(kind.state != nullptr ? kind.state(m_options) : Fingerprint{}),
          m_world(open_world(m_options, times, stop)) {
        const std::string edition = m_world->edition();
        m_is_lasting = kind.state != nullptr || !edition.empty();
        if (!m_is_lasting) {
            m_fingerprint = random_fingerprint();
            return;
        }
        voxel::ByteWriter out;
        out.add(kind.noun);
        add_options(out, m_options);
        if (kind.state != nullptr) {
            out.add(m_files_before);
            out.add(voxel::file_identity(request.maker, "program"));
        }
        out.add(edition);
        m_fingerprint = out.fingerprint();
        if (!has_same_files())
            fail_as_changed();
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_world->info(); }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        auto out = from_world([&] { return m_world->box(key); });
        check_files();
        return out;
    }
    [[nodiscard]] voxel::BoxWithInputs box_with_inputs(const voxel::BoxKey& key) override {
        return {box(key), {}};
    }
    [[nodiscard]] Fingerprint fingerprint(const voxel::InputExtent& /*reach*/) const override {
        return m_fingerprint;
    }
    /// The extents of columns of another machine's world are cached: inserting a box into cache and
    /// map queries them several times, each a request.
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        const auto fetch = [&] {
            return from_world([&] { return m_world->column(level, bx, bz); });
        };
        if (!is_remote())
            return fetch();
        constexpr std::size_t kEntry_bytes = 128;  // including the cache's overhead
        return *m_columns.get(
            {level, bx, 0, bz},
            [&] { return std::make_shared<const voxel::ColumnExtent>(fetch()); },
            [](const auto&) { return kEntry_bytes; });
    }
    [[nodiscard]] bool may_hold(const voxel::BoxRange& boxes) override {
        return m_world->may_hold(boxes);
    }
    [[nodiscard]] int useful_concurrency(int threads) const noexcept override {
        return m_world->useful_concurrency(threads);
    }
    [[nodiscard]] std::vector<std::string> damage() const override { return m_world->damage(); }
    [[nodiscard]] std::string edition() const override { return m_world->edition(); }
    void stop() noexcept override { m_world->stop(); }

    [[nodiscard]] std::string summary() const override { return std::string(m_kind.noun); }
    [[nodiscard]] std::string failure() const override { return m_changed ? changed() : ""; }
    [[nodiscard]] bool makes_all_levels() const noexcept override { return true; }
    [[nodiscard]] bool has_lasting_fingerprint() const noexcept override { return m_is_lasting; }
    [[nodiscard]] bool is_remote() const noexcept override {
        return m_kind.farm_access == FarmAccess::kByAddress;
    }
    [[nodiscard]] std::filesystem::path archive_file() const override {
        const bool is_file = m_kind.is_archive && m_kind.is_path;
        return is_file ? std::filesystem::absolute(m_options.inputs.front())
                       : std::filesystem::path();
    }

private:
    [[nodiscard]] std::string changed() const {
        return "the world " + m_options.inputs.front() +
               " has changed since the server started; start it again";
    }

    template <class Make>
    std::invoke_result_t<Make> from_world(const Make& make) {
        if (m_changed)
            throw voxel::ChangedError(changed());
        try {
            return make();
        } catch (const voxel::ChangedError&) {
            m_changed = true;
            throw voxel::ChangedError(changed());
        } catch (const util::Error& e) {
            if (is_remote())
                throw voxel::UnreachableError(e.what());
            check_files();  // a file may be unreadable because it was replaced
            throw;
        }
    }

    /// @throws ChangedError where boxes are made of the files of this name, and these are no longer
    /// those of the fingerprint
    void check_files() {
        if (m_replaced || has_same_files())
            return;
        if (!m_kind.keeps_its_files)
            fail_as_changed();
        if (!m_replaced.exchange(true))
            util::log_warn(
                "the world {} was replaced or removed; what was opened is served until the server "
                "is started again",
                m_options.inputs.front());
    }

    [[nodiscard]] bool has_same_files() const {
        if (m_kind.state == nullptr)
            return true;
        try {
            return m_kind.state(m_options) == m_files_before;
        } catch (const util::Error&) {
            return false;  // a file is gone: that is a change, too
        }
    }

    [[noreturn]] void fail_as_changed() {
        m_changed = true;
        throw voxel::ChangedError(changed());
    }

    static constexpr std::size_t kColumns_bytes = std::size_t{4} << 20;

    const WorldOptions m_options;
    const WorldKind& m_kind;
    const Fingerprint m_files_before;  ///< as they were before opening
    const std::unique_ptr<voxel::World> m_world;
    Fingerprint m_fingerprint{};
    bool m_is_lasting = false;
    std::atomic<bool> m_changed{false};
    std::atomic<bool> m_replaced{false};  ///< the files of these names are others now
    util::Cache<voxel::BoxKey, voxel::ColumnExtent, voxel::BoxKeyHash> m_columns{kColumns_bytes};
};

}  // namespace

std::unique_ptr<ServedWorld> open_served_world(const ServeRequest& request, util::StageTimes& times,
                                               const std::stop_token& stop) {
    const WorldOptions& options = request.options;
    if (options.inputs.empty())
        throw util::UsageError("open the world: nothing given; allowed: " + allowed_inputs());
    const std::string& first = options.inputs.front();
    const WorldKind& kind = find_kind(first);
    if (kind.has_squares)
        throw util::UsageError(
            "open the world: {} is {}, another input is not; allowed: inputs of one kind", first,
            kind.noun);
    check_flags(first, kind.noun, kind.flags, request.flags);
    return std::make_unique<WholeWorld>(request, kind, times, stop);
}

}  // namespace terravox::worlds
