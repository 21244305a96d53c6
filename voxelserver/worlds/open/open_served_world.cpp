#include "voxelserver/worlds/open/open_served_world.hpp"

#include <atomic>
#include <optional>
#include <random>
#include <type_traits>
#include <utility>

#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/voxel/bytes.hpp"
#include "common/voxel/changed_error.hpp"
#include "common/voxel/file_identity.hpp"
#include "common/voxel/unreachable_error.hpp"
#include "voxelserver/worlds/kind/suitable_flags.hpp"
#include "voxelserver/worlds/open/open_world.hpp"
#include "voxelserver/worlds/open/world_kinds.hpp"

namespace terravox::worlds {
namespace {

using voxel::Fingerprint;

void add_options(voxel::ByteWriter& out, const WorldOptions& options) {
    out.add(static_cast<std::uint64_t>(options.inputs.size()));
    for (const std::string& input : options.inputs)
        out.add(input);
    out.add(static_cast<std::uint64_t>(options.orthophotos.size()));
    for (const auto& image : options.orthophotos)
        out.add(image.string());
    out.add(options.crs);
    out.add(options.vertical_unit);
    out.add(options.voxel_m);
    out.add(options.dimension);
    out.add(options.base_m.has_value());
    out.add(options.base_m.value_or(0));
    const procedural::Settings& noise = options.generated;
    out.add(noise.seed);
    out.add(noise.water_level);
    out.add(noise.world_height);
    out.add(noise.harmonics);
    out.add(noise.frequency);
    out.add(noise.smoothness);
    out.add(noise.trees);
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
        m_fingerprint = out.print();
        check_files();
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_world->info(); }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        auto out = from_world([&] { return m_world->box(key); });
        check_files();
        return out;
    }
    [[nodiscard]] voxel::BoxWithInputs traced_box(const voxel::BoxKey& key) override {
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

    /// @throws ChangedError where the files are no longer those of the fingerprint
    void check_files() {
        if (m_kind.state == nullptr)
            return;
        std::optional<Fingerprint> now;
        try {
            now = m_kind.state(m_options);
        } catch (const util::Error&) {
            // A file is gone: that is a change, too.
        }
        if (now == m_files_before)
            return;
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
    util::Cache<voxel::BoxKey, voxel::ColumnExtent, voxel::BoxKeyHash> m_columns{kColumns_bytes};
};

}  // namespace

std::unique_ptr<ServedWorld> open_served_world(const ServeRequest& request, util::StageTimes& times,
                                               const std::stop_token& stop) {
    const WorldOptions& options = request.options;
    if (options.inputs.empty())
        throw util::UsageError("open the world: nothing given; allowed: " + allowed_inputs());
    const std::string& first = options.inputs.front();
    const WorldKind& kind = kind_of(first);
    if (kind.has_squares)
        throw util::UsageError("open the world: " + first + " is " + std::string(kind.noun) +
                               ", another input is not; allowed: inputs of one kind");
    check_flags(first, kind.noun, kind.flags, request.flags);
    return std::make_unique<WholeWorld>(request, kind, times, stop);
}

}  // namespace terravox::worlds
