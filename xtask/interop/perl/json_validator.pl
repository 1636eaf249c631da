# Adapter for JSON::Validator with draft 2020-12. Reads jobs and writes one JSON line for each schema and case; see
# xtask/interop/README.md.
use strict;
use warnings;

use JSON::Validator;
use Mojo::File qw(path);
use Mojo::JSON qw(decode_json encode_json from_json false true);

$| = 1;

my @lines     = map { decode_json($_) } split /\n/, path($ARGV[0])->slurp;
my %documents = map { $_->{document} => decode_json(path($_->{path})->slurp) } grep { $_->{document} } @lines;

write_line({version => JSON::Validator->VERSION});
run($_) for grep { $_->{schema} } @lines;

sub run {
  my $job   = shift;
  my $check = eval { compile($job->{schema}) };
  return write_line({job => $job->{job}, error => brief($@)}) unless $check;
  write_line({job => $job->{job}});
  my $index = 0;
  for my $text (@{$job->{cases}}) {
    my $verdict = eval { $check->($text) } || {error => brief($@)};
    write_line({job => $job->{job}, case => $index++, %$verdict});
  }
}

# Compiles the schema into a function that checks the text of an instance.
sub compile {
  my $address = shift;
  my $validator = JSON::Validator->new;
  $validator->store->add($_ => $documents{$_}) for keys %documents;
  my $schema = $validator->schema({'$schema' => 'https://json-schema.org/draft/2020-12/schema', '$ref' => $address})->schema;
  return sub {
    my @errors = $schema->validate(from_json(shift));
    return {valid => @errors ? false : true, message => @errors ? "$errors[0]" : undef};
  };
}

sub brief { substr "$_[0]", 0, 300 }

sub write_line { print encode_json(shift), "\n" }
