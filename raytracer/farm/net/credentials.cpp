#include "raytracer/farm/net/credentials.hpp"

#include <fstream>

#include "common/util/secret.hpp"
#include "raytracer/farm/net/certificates.hpp"
#include "raytracer/farm/net/openssl.hpp"

namespace terravox::net {
namespace {

void free_stack(STACK_OF(X509) * stack) noexcept {
    sk_X509_free(stack);
}

constexpr std::streamsize kMaxPem_bytes = 1 << 20;

/// Checks the chain as the peer will: signed by this CA, valid today, for both ends, with the
/// farm's name.
/// @param chain the certificate, and those between it and the CA
void check_chain(const std::vector<CertificatePtr>& ca, const std::vector<CertificatePtr>& chain,
                 const std::filesystem::path& path) {
    const std::unique_ptr<X509_STORE, FreeBy<X509_STORE_free>> store(X509_STORE_new());
    const std::unique_ptr<STACK_OF(X509), FreeBy<free_stack>> between(sk_X509_new_null());
    const std::unique_ptr<X509_STORE_CTX, FreeBy<X509_STORE_CTX_free>> context(
        X509_STORE_CTX_new());
    const auto failed = [&] {
        return util::Error("check the certificate " + path.string() + ": " + openssl_reason());
    };
    if (!store || !between || !context)
        throw failed();
    for (const auto& one : ca)
        if (X509_STORE_add_cert(store.get(), one.get()) != 1)
            throw failed();
    for (std::size_t i = 1; i < chain.size(); ++i)
        if (sk_X509_push(between.get(), chain[i].get()) == 0)
            throw failed();
    const auto refuse = [&](const std::string& why) {
        return RefusedError("check the certificate " + path.string() + ": " + why);
    };
    for (const int purpose : {X509_PURPOSE_SSL_SERVER, X509_PURPOSE_SSL_CLIENT}) {
        if (X509_STORE_CTX_init(context.get(), store.get(), chain.front().get(), between.get()) !=
            1)
            throw failed();
        X509_STORE_CTX_set_flags(context.get(), X509_V_FLAG_PARTIAL_CHAIN);
        X509_STORE_CTX_set_purpose(context.get(), purpose);
        if (X509_verify_cert(context.get()) != 1)
            throw refuse(X509_verify_cert_error_string(X509_STORE_CTX_get_error(context.get())));
        X509_STORE_CTX_cleanup(context.get());
    }
    if (X509_check_host(chain.front().get(), kFarmName.data(), kFarmName.size(),
                        X509_CHECK_FLAG_NEVER_CHECK_SUBJECT, nullptr) != 1)
        throw refuse("it does not carry the name " + std::string(kFarmName) +
                     "; terravox farm certs makes certificates that do");
    if (find_role(chain.front().get()).empty())
        throw refuse("it names no role; terravox farm certs makes certificates with a role");
}

}  // namespace

std::string text_of_pem(const std::filesystem::path& path, const char* what) {
    std::ifstream in(path, std::ios::binary);
    std::string text(static_cast<std::size_t>(kMaxPem_bytes) + 1, '\0');
    if (in)
        in.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!in.is_open() || in.bad() || (in.gcount() == 0 && !in.eof()))
        throw util::Error(std::string("read the ") + what + " " + path.string() +
                          ": it cannot be read");
    if (in.gcount() > kMaxPem_bytes)
        throw util::Error(std::string("read the ") + what + " " + path.string() +
                          ": it is larger than 1 MiB");
    text.resize(static_cast<std::size_t>(in.gcount()));
    return text;
}

void check(const Credentials& credentials) {
    const bool any =
        !credentials.ca.empty() || !credentials.certificate.empty() || !credentials.key.empty();
    const bool all =
        !credentials.ca.empty() && !credentials.certificate.empty() && !credentials.key.empty();
    if (any && !credentials.token.empty())
        throw util::UsageError(
            "use the farm's credentials: both a token and certificates are given; allowed: one of "
            "them");
    if (any && !all)
        throw util::UsageError(
            "use the farm's certificates: the CA, a certificate and its key belong together; "
            "allowed: all three, or none");
    if (!any && credentials.token.empty())
        throw util::UsageError(
            "use the farm's credentials: there are none; allowed: a token, or certificates");
    if (!any)
        util::check_token(credentials.token, "use the farm's credentials");
}

Pem read_pem(const Credentials& credentials) {
    Pem out{text_of_pem(credentials.ca, "CA certificate"),
            text_of_pem(credentials.certificate, "certificate"),
            text_of_pem(credentials.key, "key")};
    const auto no_pem = [](const std::filesystem::path& path, const char* what) {
        ERR_clear_error();
        return util::Error("read " + path.string() + ": it holds no " + what + "; allowed: PEM" +
                           (std::string(what) == "key" ? " without a pass phrase" : ""));
    };
    const auto ca = parse_certificates(out.ca);
    const auto chain = parse_certificates(out.certificate);
    const auto key = parse_key(out.key);
    if (ca.empty())
        throw no_pem(credentials.ca, "certificate");
    if (chain.empty())
        throw no_pem(credentials.certificate, "certificate");
    if (!key)
        throw no_pem(credentials.key, "key");
    if (X509_check_private_key(chain.front().get(), key.get()) != 1) {
        ERR_clear_error();
        throw util::Error("read the key " + credentials.key.string() +
                          ": it belongs to another certificate than " +
                          credentials.certificate.string());
    }
    check_chain(ca, chain, credentials.certificate);
    return out;
}

std::shared_ptr<grpc::ChannelCredentials> to_dial(const Pem& pem) {
    return grpc::SslCredentials(
        {.pem_root_certs = pem.ca, .pem_private_key = pem.key, .pem_cert_chain = pem.certificate});
}

std::shared_ptr<grpc::ServerCredentials> to_listen(const Pem& pem) {
    grpc::SslServerCredentialsOptions options(
        GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
    options.pem_root_certs = pem.ca;
    options.pem_key_cert_pairs.push_back({pem.key, pem.certificate});
    return grpc::SslServerCredentials(options);
}

}  // namespace terravox::net
